"""The report of a run that designs a feed drive's fuzzy controller, and its pictures."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from imported_files import SHARED, SHARED_SIGNALS
from jk04 import CHANGE_TERMS, ERROR_TERMS, rule_singletons
from places import ROOT
from wording import refused, refused_command

from hfc_design.cli import main
from hfc_design.controllers.flc import section as fuzzy_plots
from hfc_design.controllers.flc.rules import LABELS
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.formats.reading import Wish, imported
from hfc_design.runtime import Controller

INFINITY = float("inf")


def flc():
    return load_design("jee-koren-2004-flc").controller


def cells_of(figure):
    """(row, column) -> the number in that cell."""
    return {
        (round(text.get_position()[1]), round(text.get_position()[0])): text.get_text()
        for text in figure.axes[0].texts
    }


def test_heat_map_writes_the_table():
    table = np.array(rule_singletons("I"))
    table[1, 6] = -7.56
    changed = {"rules": flc().rules.model_copy(update={"centroids": table.tolist()})}
    figure = fuzzy_plots.rule_table(flc().model_copy(update=changed), "a title")
    cells = cells_of(figure)
    assert len(cells) == 49
    assert cells[0, 0] == "\u221232.0"  # NL of e, NL of its change
    assert cells[1, 6] == "\u22127.6"
    assert cells[5, 0] == "8.0"
    for place, text in cells.items():
        assert float(text.replace("\u2212", "-")) == pytest.approx(table[place], abs=0.05)
    axes = figure.axes[0]
    for labels in (axes.get_xticklabels(), axes.get_yticklabels()):
        assert [label.get_text() for label in labels] == list(LABELS)
    assert axes.yaxis_inverted()
    shades = axes.collections[0].get_array()
    np.testing.assert_allclose(np.reshape(shades, (7, 7)), table)
    moved = fuzzy_plots.rule_table(flc().model_copy(update=changed), "", before=flc())
    assert cells_of(moved) == cells
    shades = np.reshape(moved.axes[0].collections[0].get_array(), (7, 7))
    assert shades[1, 6] == pytest.approx(0.44)
    assert np.count_nonzero(shades) == 1


def test_terms_are_the_triangles_of_table_3():
    for axes, triangles in zip(
        fuzzy_plots.terms(flc(), "").axes, (ERROR_TERMS, CHANGE_TERMS), strict=True
    ):
        assert len(axes.lines) == 7
        for line, (left, centre, right) in zip(axes.lines, triangles, strict=True):
            x, y = line.get_data()
            assert x[1] == centre
            assert (x[0] == left and y[0] == 0) or (left == -INFINITY and y[0] == 1)
            assert (x[2] == right and y[2] == 0) or (right == INFINITY and y[2] == 1)
        assert [text.get_text() for text in axes.texts] == list(LABELS)
        assert "BLU" in axes.get_xlabel()
    assert len(fuzzy_plots.terms(flc(), "", before=flc()).axes[0].lines) == 14


LESSON = ROOT / "docs" / "lesson.fll"


@pytest.fixture
def lesson():
    return imported(LESSON, Wish())


def command(design):
    """At an error of 20 BLU that does not change: rule P, Z alone."""
    controller = Controller(design)
    controller.step({"error": 20.0})
    return controller.step({"error": 20.0})


def test_a_rule_and_what_its_term_stands_for(lesson):
    assert command(lesson) == 60.0
    assert command(load_design(lesson, ["controller.rules.labels.2.1=forward"])) == 120.0
    assert command(load_design(lesson, ["controller.rules.output_terms.more=80"])) == 80.0


@pytest.fixture(scope="module")
def design():
    return imported(SHARED["fll"], Wish(signals=SHARED_SIGNALS))


@pytest.fixture
def written(design, tmp_path):
    (tmp_path / "own.json").write_text(design_json(design))
    return tmp_path / "own.json"


@pytest.fixture
def explain(written):
    return lambda *arguments: CliRunner().invoke(main, ["explain", str(written), *arguments])


def test_explain_takes_them_like_the_signals(explain):
    own = explain("--json", "--at", "gap=2,drift=-0.5")
    assert own.exit_code == 0
    assert own.stdout == explain("--json", "--at", "error=2,error_change=-0.5").stdout
    told = json.loads(own.stdout)
    assert told["signals"] == {"error": 2.0, "error_change": -0.5}
    before = json.loads(explain("--json", "--at", "gap=2,previous_gap=2.5").stdout)
    assert before["units"] == told["units"]
    assert "gap (error)" in explain("--at", "gap=2,drift=-0.5").stdout


@pytest.mark.parametrize("at", ["gap=2,grift=1", "gap=2,error=1", "gap=2"])
def test_mistakes(written, at):
    refused_command("explain", written, "--at", at)


@pytest.mark.parametrize("change", ["labels.2.1=forwrd", "centroids.2.1=5", "output_terms.mroe=80"])
def test_what_cannot_be(lesson, change):
    with refused() as found:
        load_design(lesson, [f"controller.rules.{change}"])
    assert f"controller.rules.{change.partition('=')[0]}" in found.refusal


def test_a_mistyped_term_of_one_axis(lesson):
    own = lesson.controller.model_dump(mode="json")
    each = lesson.model_dump(mode="json") | {
        "controller": {"kind": "per-axis", "axes": {"x": own, "y": own}, "sample_time_s": 0.01}
    }
    whole, key = parse_design(json.dumps(each), "both"), "controller.axes.y.rules.output_terms.mroe"
    with refused() as found:
        load_design(whole, {key: 80})
    assert key in found.refusal
