"""What the picture of a contour shows, read back from the figure."""

import numpy as np
import pytest
from read_figures import lines_of

from hfc_design.motion import contour as contours
from hfc_design.motion.trajectories import Circle, Polyline
from hfc_design.plotting.figure import WIDTH
from hfc_design.plotting.files import image
from hfc_design.report.plots import contour as picture


def contour(trajectory, time, actual, title):
    """The picture of a machine at ``actual`` (2, steps) [mm] that counts in BLU of 0.01 mm."""
    positions = (actual - trajectory.samples(time).position[:, :1]) / 0.01
    return picture(contours.contour(trajectory, time, positions, "BLU", 0.01), time, title)


def test_circle_that_is_too_large_by_70_um():
    """7 BLU: a division is 5 BLU, the first of 1, 2, 5, 10 that is at least half of the error.

    A division takes 8 % of 40 mm, so that 0.05 mm become 3.2 mm: 64 times.
    """
    circle = Circle(radius_mm=20.0, feed_mm_min=377.0, cycles=1.5)
    time = np.arange(0.0, 30.0, 0.01)
    actual = 20.07 / 20 * circle.samples(time).position
    figure = contour(circle, time, actual, "a title")
    upper, lower = figure.axes
    lines = lines_of(upper)
    np.testing.assert_allclose(np.hypot(*lines["path"]), 20.0)
    drawn = lines["error, 64 times enlarged"]
    np.testing.assert_allclose(np.hypot(*drawn), 20 + 64 * 0.07, rtol=1e-4)
    radii = [np.hypot(*line.get_data()).mean() for line in upper.lines]
    assert sorted(radii)[0] == pytest.approx(16.8, rel=1e-3)
    assert "5 BLU off" in lines
    marks = lines["largest after a reversal"]
    assert marks.shape == (2, 5)  # 90 to 450 deg, in steps of 90 deg, and no more at 540 deg
    assert lower.get_ylabel() == "contour error [BLU]"
    np.testing.assert_allclose(lower.lines[0].get_ydata(), 7.0, rtol=1e-9)
    assert upper.get_title() == "a title"
    assert figure.get_figwidth() == WIDTH
    assert image(figure, "png").startswith(b"\x89PNG")


def test_overshoot_at_a_corner_points_beyond_the_corner():
    corner = Polyline(points_mm=[(0, 0), (20, 0), (20, 20)], feed_mm_min=600.0)
    time = np.arange(0.0, corner.duration_s, 0.01)
    actual = corner.samples(time).position.copy()
    k = int(np.argmax(actual[1] > 0.05))
    actual[:, k] = (20.1, -0.1)
    upper, lower = contour(corner, time, actual, "").axes
    drawn = next(v for name, v in lines_of(upper).items() if "enlarged" in name)
    # 0.141 mm: a division is 0.1 mm and 8 % of 20 mm, so 16 times.
    assert drawn[:, k] == pytest.approx([20 + 1.6, -1.6])
    grey = lines_of(upper)["10 BLU off"]
    assert np.isnan(grey).any()  # torn at the corner, where it would run across
    assert lower.lines[0].get_ydata()[k] == pytest.approx(-10 * np.sqrt(2))
    assert not any("reversal" in name for name in lines_of(upper))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_perfect_and_diverged_motions_are_drawn_too(bad):
    circle = Circle(radius_mm=20.0, feed_mm_min=3770.0)
    time = np.arange(0.0, 2.0, 0.01)
    actual = circle.samples(time).position
    image(contour(circle, time, actual, "perfect"), "png")
    actual[:, 150:] = bad
    figure = contour(circle, time, actual, "diverged")
    assert len(figure.axes[1].lines[0].get_xdata()) == 150
    image(figure, "png")
