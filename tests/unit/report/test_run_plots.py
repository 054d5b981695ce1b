"""Plots and diagrams of a run, also of one that diverged."""

import re

import numpy as np
import pytest
from random_runs import INPUTS, design

from hfc_design.controllers.hierarchical import drawn_tree as diagrams
from hfc_design.controllers.hierarchical import pictures
from hfc_design.core.records import RunError, UserError
from hfc_design.files.pairing import load_design
from hfc_design.pictures.curves import SLICES
from hfc_design.pictures.files import image, save
from hfc_design.report import plots, searches
from hfc_design.report.parts import sections
from hfc_design.search.loop import History
from plants import C_AXIS


def changed(evaluation, **axis):
    """The evaluation with parts of its only axis replaced."""
    return evaluation._replace(axes=(evaluation.axes[0]._replace(**axis),))


def moving(evaluation, values):
    """The motion of its only axis with these values (steps,) for everything."""
    motion = evaluation.axes[0].motion
    state = type(motion.state)(*[values] * len(motion.state))
    return motion._replace(error=values, command=values, state=state)


def test_response_shows_a_load_only_where_there_is_one(report):
    with_load = report[0][1].evaluation
    happens = with_load.axes[0].happens
    without = changed(with_load, happens=happens._replace(loads=np.zeros_like(happens.loads)))
    assert len(plots.response(with_load, "x").axes) == 5
    assert len(plots.response(without, "x").axes) == 4


def test_long_curves_keep_their_peaks(report):
    evaluation = report[0][1].evaluation
    time = 1e-5 * np.arange(100_001)
    error = np.sin(time)
    error[[777, 54_321, -1]] = 5.0, -7.0, 3.0
    long = changed(
        evaluation._replace(time=time),
        happens=evaluation.axes[0].happens._replace(reference=time, loads=[0 * time]),
        motion=moving(evaluation, error),
    )
    line = plots.response(long, "long").axes[1].lines[0]
    assert len(line.get_xdata()) <= 2 * SLICES + 2
    assert np.all(np.diff(line.get_xdata()) > 0)
    assert {5.0, -7.0, 3.0} <= set(line.get_ydata())  # in rad, as no mrad is read so far


def test_history_of_one_generation_where_everything_diverged():
    history = History(np.array([np.nan]), np.array([np.nan]), np.array([30]), np.array([3]))
    assert image(searches.history(history, "merit"), "svg")


@pytest.mark.parametrize(("inputs", "tree"), [(2, 0), (6, 0), (6, 944)])
def test_diagrams_show_every_unit_and_input(inputs, tree):
    found = design(inputs, tree)
    drawing = image(diagrams.drawn_tree(found.controller, C_AXIS), "svg").decode()
    words = {word for name in INPUTS[:inputs] for word in name.split("_")}
    texts = set(re.findall(r">([^<>]+)</t", drawing))
    assert words <= {word for text in texts for word in text.split()}
    assert {f"unit {unit.id}" for unit in found.controller.units} <= texts
    for k, unit in enumerate(found.controller.units):
        drawing = image(pictures.table(found.controller, k), "svg").decode()
        assert f"unit {unit.id}<" in drawing
        assert f"row: {diagrams.readable(unit.row_input)}<" in drawing


def test_diagrams_need_a_hierarchy(report):
    own = report[0][1]
    names = {name: load_design(name) for name in ("pd-only", "lin-lee-1999-table-1")}
    drawn = [
        sum(len(section.drawings) for section in sections(design, own.evaluation, report[0][0]))
        for design in names.values()
    ]
    assert drawn == [0, 9]  # a tree, four tables and four surfaces


@pytest.mark.parametrize(
    ("suffix", "magic"), [("png", b"\x89PNG"), ("PDF", b"%PDF"), ("svg", b"<?xml")]
)
def test_save_response(report, tmp_path, suffix, magic):
    path = tmp_path / f"plot.{suffix}"
    for _ in range(2):
        save(plots.response(report[0][1].evaluation, "title"), path)
        first = path.read_bytes()
        assert first.startswith(magic)
    save(plots.response(report[0][1].evaluation, "title"), path)
    assert path.read_bytes() == first


def test_save_response_refuses_a_suffix(report, tmp_path):
    for name in ("plot.gif", "plot"):
        with pytest.raises(UserError, match=r"has to end in \.png, \.svg or \.pdf$"):
            save(plots.response(report[0][1].evaluation, "title"), tmp_path / name)
    with pytest.raises(RunError, match="cannot be written"):
        save(plots.response(report[0][1].evaluation, "title"), tmp_path / "none" / "plot.png")
