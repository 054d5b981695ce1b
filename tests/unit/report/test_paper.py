"""Figures and tables of pages for a paper: sizes, letters, texts, and where they lie."""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
import tex
from matplotlib.backends.backend_agg import FigureCanvasAgg
from report_pages import NAME
from wording import refused, refused_command

from hfc_design.files.named_scenario import load_scenario
from hfc_design.plotting.column import in_column
from hfc_design.plotting.figure import above, distinct, finish, framed
from hfc_design.plotting.files import image
from hfc_design.report.paper import Paper
from hfc_design.report.parts import baselines, pass_conditions

#: How matplotlib makes a percent sign print itself, which no simple reader knows.
PERCENT = r"\catcode`\%=\active\def%{\%}"
INJECTED = r"\input{evil}%$x_1$"


def drawn():
    """A figure with long numbers, a legend of long names, and one that is a command to TeX."""
    figure = framed(3.0, top=0.6)
    axes = figure.subplots()
    for k, name in enumerate([INJECTED, "a" * 45, "b" * 45]):
        axes.plot([0, 1], [k, 1234567.8 * k], label=name)
    finish(axes, "largest error [µrad]", "time [s]")
    above(figure, axes)
    return figure


def extents(figure, *artists):
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    return [artist.get_window_extent(renderer) for artist in artists]


@pytest.mark.parametrize("width", [3.3, 3.5, 7.1])
def test_nothing_leaves_the_figure_or_lies_on_something_else(width):
    figure = drawn()
    in_column(figure, width)
    (axes,), (legend,) = figure.axes, figure.legends
    label, first, title = axes.yaxis.label, axes.get_yticklabels()[-2], axes.yaxis.get_offset_text()
    names, panel, words, number, power = extents(figure, legend, axes, label, first, title)
    assert figure.get_figwidth() == width
    for box in (names, words, number):
        assert 0 <= box.x0 < box.x1 <= figure.bbox.width
        assert 0 <= box.y0 < box.y1 <= figure.bbox.height
    assert words.x1 < number.x0 < number.x1 < panel.x0
    assert names.y0 > panel.y1 > power.y1 > panel.y1 - 5  # inside, not on the panel above


def test_a_pdf_has_its_size_letters_that_publishers_take_and_the_same_bytes():
    figure, again = drawn(), drawn()
    for one in (figure, again):
        in_column(one, 3.5)
    content = image(figure, "pdf")
    assert content == image(again, "pdf")
    (box,) = re.findall(rb"/MediaBox \[([^\]]*)\]", content)
    assert [float(x) for x in box.split()][2] == pytest.approx(3.5 * 72)
    assert b"/Type3" not in content
    assert b"CreationDate" not in content


def test_a_pgf_needs_no_tex_and_holds_no_command_of_a_user(monkeypatch):
    monkeypatch.setattr(subprocess, "Popen", None)  # what asks a TeX program would fail
    monkeypatch.setitem(os.environ, "PATH", "")
    figure = drawn()
    in_column(figure, 3.5)
    text = image(figure, "pgf").decode()
    assert text == image(figure, "pgf").decode()
    text = text.replace(PERCENT, "")
    assert tex.depth(text) == (0, 0)
    assert r"\input" not in text
    shown = [tex.printed(part) for part in re.findall(r"\\else\\\^\{\}\\fi\}(.*)\}\}%", text)]
    assert INJECTED in shown
    assert "largest error [µrad]" in shown
    assert rf"\pgfqpoint{{3.500000in}}{{{figure.get_figheight():f}in}}" in text
    assert text.count(r"\begin{pgfscope}") == text.count(r"\end{pgfscope}") > 10


def test_an_image_is_no_pgf(tmp_path):
    figure = framed(2.0, top=0.2)
    figure.subplots().imshow(np.eye(3))
    paper = Paper("pgf", 88.9, tmp_path / "figures", None)
    with refused() as found:
        paper.write(type("Page", (), {"figures": {"own": figure}, "tables": {}}))
    assert found.where == "own"
    assert not (tmp_path / "figures").exists()


def test_labels_that_are_cut_stay_apart():
    names = ["runs/of/a/long/path/1", "runs/of/a/long/path/2", "pd-only"]
    labels = distinct(names, 16)
    assert [*labels] == names
    assert len(set(labels.values())) == 3
    assert all(len(label) <= 16 for label in labels.values())
    assert labels["pd-only"] == "pd-only"
    assert labels[names[0]].endswith("path/1")
    same = distinct(["a" * 30 + "Ω" + "b" * 30, "a" * 30 + "漢" + "b" * 30], 16)
    assert len(set(same.values())) == 2


def test_the_loop_of_one_machine_is_a_rival_on_that_machine_only():
    stage = {"name": "x", "plant": {"name": "positioning-stage"}}
    stage |= {"reference": {"kind": "step", "height": 0.01}, "controller": {"kind": "pid"}}
    assert [*baselines(load_scenario(stage))] == ["emps-cascade"]
    assert not baselines(load_scenario(stage, {"plant.parameters.mass": 40.0}))
    other = load_scenario("c-axis-ramp", {"plant.parameters.stiffness": 150.0})
    assert len(baselines(other)) == 3


def test_it_says_what_everything_is():
    units = {"late_error": "2 mrad", "stick_slip": 0.0}
    asked = load_scenario("c-axis-ramp", {f"constraints.{key}": x for key, x in units.items()})
    assert pass_conditions(asked) == (
        "the loop is stable, and has at most late_error of 0.002 [rad], stick_slip of 0 [1]"
    )
    assert "sets no limits" in pass_conditions(load_scenario("feed-drive-circle"))


@pytest.mark.parametrize(
    ("arguments", "where"),
    [
        ((NAME, "--each"), NAME),
        ((".", "--out", "x.html"), "--out x.html"),
        ((NAME, "--width", "88mm"), "--width"),
        ((NAME, "--figures", "png"), "--figures png"),
        ((NAME, "--figures", "pdf", "--width", "3mm"), "--width 3mm"),
    ],
    ids=["each", "folder", "width", "png", "narrow"],
)
def test_what_does_not_go_together_is_a_line(arguments, where, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = refused_command("report", *arguments)
    assert found.where == where
    assert found.count("\n") == 1
    assert not list(Path().iterdir())
