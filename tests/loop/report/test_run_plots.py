"""Plots of a run."""

import numpy as np
import pytest
from report_pages import NAME
from wording import refused

from hfc_design.core.records import RunError
from hfc_design.files.loop_setup import load_design
from hfc_design.pictures.curves import SLICES
from hfc_design.pictures.files import save
from hfc_design.report import plots
from hfc_design.report.parts import sections


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


def test_diagrams_need_a_hierarchy(report):
    own = report[0][1]
    names = {name: load_design(name) for name in ("pd-only", NAME)}
    drawn = [
        sum(len(section.drawings) for section in sections(design, own.evaluation, report[0][0]))
        for design in names.values()
    ]
    assert drawn == [1, 10]  # the loop; a tree, four tables and four surfaces


@pytest.mark.parametrize(
    ("suffix", "magic"), [("png", b"\x89PNG"), ("PDF", b"%PDF"), ("svg", b"<?xml")]
)
def test_a_picture_is_saved_and_the_same_each_time(report, tmp_path, suffix, magic):
    path, found = tmp_path / f"plot.{suffix}", []
    for _ in range(2):
        save(plots.response(report[0][1].evaluation, "title"), path)
        found.append(path.read_bytes())
    assert found[0].startswith(magic)
    assert found[0] == found[1]


def test_where_no_picture_can_be_saved(report, tmp_path):
    figure = plots.response(report[0][1].evaluation, "title")
    for name in ("plot.gif", "plot"):
        with refused() as found:
            save(figure, tmp_path / name)
        assert found.where == str(tmp_path / name)
    with refused(RunError) as found:
        save(figure, tmp_path / "none" / "plot.png")
    assert found.where == str(tmp_path / "none" / "plot.png")
