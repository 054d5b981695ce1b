"""Pictures of a comparison: ball bars show radii, contours what lies across a path."""

import base64
import re

import numpy as np
import pytest
from comparison_fixtures import HOSTILE, SOFTER
from matplotlib.projections.polar import PolarAxes

from hfc_design.motion.trajectories import Circle
from hfc_design.report.comparison.plots import BAR, contours
from hfc_design.report.comparison.traces import data, panels
from hfc_design.report.plots import SHARE


def test_data_of_the_page_read_back(spindles):
    bout = spindles.bouts[0]
    shown = panels(bout)
    found = data(bout, shown)
    assert found["step"] == pytest.approx(0.001)
    for panel, told in zip(shown, found["panels"], strict=True):
        assert told["label"] == panel.label
        assert told["names"] == list(panel.curves)
        assert (told["reference"] is None) == (panel.reference is None)
        for values, curve in zip(panel.curves.values(), told["curves"], strict=True):
            numbers = np.frombuffer(base64.b64decode(curve), "<f4")
            assert numbers.max() == np.float32(values.max())
            assert numbers.min() == np.float32(values.min())
    time = 1e-3 * np.arange(2000)
    name, side = next(iter(bout.results.items()))
    longer = side._replace(motion=side.motion._replace(time=time))
    told = data(bout._replace(results={name: longer}), [])
    assert told["step"] == pytest.approx(0.002)  # two values of four samples of 1 ms


def test_ball_bar_draws_the_radius(tables):
    bout = tables.bouts[0]
    figure, told = contours(bout)
    (axes,) = figure.axes
    assert isinstance(axes, PolarAxes)
    path = bout.results[SOFTER].motion.contour
    assert isinstance(path.trajectory, Circle)
    largest = max(np.abs(x.motion.contour.error).max() for x in bout.results.values())
    division = next(x for x in (1, 2, 5, 10, 20, 50) if x >= largest / 2)
    assert told.startswith(f"One division, from one grey line to the next, is {division} BLU")
    assert f"({10 * division} µm)" in told  # of 10 µm each
    enlarged = BAR * path.trajectory.radius_mm / (0.01 * division)
    assert f"{enlarged:.0f} times enlarged" in told
    circle, first, second = axes.lines
    assert (circle.get_ydata() == 1.0).all()
    radius = np.hypot(*path.actual) / path.trajectory.radius_mm
    shown = second.get_ydata()
    assert shown.max() == pytest.approx(1 + enlarged * (radius.max() - 1))
    assert shown.min() == pytest.approx(1 + enlarged * (radius.min() - 1))
    assert first.get_label() == "jee-koren-2004-pid"
    assert contours(bout._replace(results={})) is None


def test_a_line_has_its_deviations_across_it(tables):
    bout = tables.bouts[1]
    figure, told = contours(bout)
    (axes,) = figure.axes
    path = bout.results[SOFTER].motion.contour
    drawn = np.stack(axes.lines[-1].get_data())
    angle = np.deg2rad(26.6)
    off = np.array([-np.sin(angle), np.cos(angle)]) @ drawn
    enlarged = int(told.split(" times enlarged")[0].split()[-1])
    assert np.abs(off).max() == pytest.approx(enlarged * 0.01 * np.abs(path.error).max(), rel=0.01)
    size = path.samples.position[0].max()
    assert np.abs(off).max() < 3 * SHARE * size


def numbers(curve):
    return [float(x) for x in re.findall(r"-?[\d.]+", curve)]


def test_a_diverged_motion_does_not_hide_the_others(spindles):
    bout = spindles.bouts[0]
    one = bout.results[HOSTILE].motion
    (axis,) = one.axes
    error = axis.motion.error.copy()
    error[50:200] = 10.0 ** np.arange(150)
    error[200:] = 1e150
    gone = axis._replace(motion=axis.motion._replace(error=error))
    lost = bout.results[HOSTILE]._replace(motion=one._replace(axes=(gone,), diverged=True))
    shown = panels(bout._replace(results=bout.results | {HOSTILE: lost}))
    assert shown[0].label == "error [mrad]"
    assert np.isfinite(shown[0].curves["pd-only"]).all()
    assert np.isnan(shown[0].curves[HOSTILE][60:]).all()
