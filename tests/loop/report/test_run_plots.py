"""Plots of a run."""

import numpy as np
import pytest

from hfc_design.pictures.curves import SLICES
from hfc_design.pictures.files import save
from hfc_design.report import plots


def changed(evaluation, **axis):
    """The evaluation with parts of its only axis replaced."""
    return evaluation._replace(axes=(evaluation.axes[0]._replace(**axis),))


def moving(evaluation, values):
    """The motion of its only axis with these values (steps,) for everything."""
    motion = evaluation.axes[0].motion
    state = type(motion.state)(*[values] * len(motion.state))
    return motion._replace(error=values, command=values, state=state)


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
