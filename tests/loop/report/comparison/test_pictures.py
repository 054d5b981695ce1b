"""Pictures of a comparison: ball bars show radii, contours what lies across a path."""

import base64
import re
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest
from comparison_fixtures import HOSTILE, SOFTER
from matplotlib.projections.polar import PolarAxes
from read_figures import read_apart

from hfc_design.motion.trajectories import Circle
from hfc_design.pictures.column import in_column
from hfc_design.pictures.figure import WIDTH
from hfc_design.pictures.files import address, image, small_address
from hfc_design.report import overlaid
from hfc_design.report.comparison.plots import BAR, contours, machines, motions, ratios
from hfc_design.report.comparison.traces import data, panels
from hfc_design.report.errors import errors
from hfc_design.report.plots import SHARE


def test_panels_have_what_moved_in_readable_units(spindles):
    bout = spindles.bouts[0]
    shown = panels(bout)
    units = [panel.label for panel in shown]
    assert units == ["error [mrad]", "voltage [V]", "velocity [mrad/s]", "position [mrad]"]
    name = "pd-only"
    axis = bout.results[name].motion.axes[0]
    np.testing.assert_allclose(shown[0].curves[name], 1e3 * axis.motion.error)
    place = 1e3 * axis.motion.state.spindle_angle
    np.testing.assert_allclose(shown[3].curves[name], place, atol=1e-9)
    np.testing.assert_allclose(shown[3].reference, 1e3 * axis.reference)


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


def test_a_design_has_one_look_in_every_picture_and_needs_no_colour(spindles):
    """On the page of a comparison, and where ``hfc plot`` draws the same designs."""
    bout = spindles.bouts[0]
    own = {name: one.motion for name, one in bout.results.items()}
    each = (motions(bout, panels(bout)), overlaid.motions(own, ""), errors(own))
    drawn = [[line.get_color() for line in figure.axes[0].lines[:2]] for figure in each]
    assert drawn[0] == drawn[1] == drawn[2]
    assert len(set(drawn[0])) == 2
    dashes = [[line.get_linestyle() for line in figure.axes[-1].lines[:2]] for figure in each]
    assert dashes == [["-", "--"]] * 3


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


def test_ratios_have_a_row_a_motion(spindles, tables):
    for found in (spindles, tables):
        figure = ratios(found)
        left, right = figure.axes
        labels = [label.get_text().replace("\n", "") for label in left.get_yticklabels()]
        assert labels == [bout.name for bout in found.bouts]
        first = found.differences[0]
        dots = [line for line in left.lines if len(line.get_xdata()) == 1]
        assert float(dots[0].get_xdata()[0]) == pytest.approx(first.ratio)
        assert len([line for line in right.lines if len(line.get_xdata()) == 1]) == 2


@pytest.mark.parametrize("width", [3.3, 88 / 25.4, 5.4])
def test_ratios_leave_little_beside_their_labels_and_say_over_what(tables, width):
    figure = ratios(tables)
    if width < WIDTH:
        in_column(figure, width)
    figure.draw_without_rendering()
    (axes, _), dots = figure.axes, figure.dpi
    boxes = [label.get_window_extent() for label in axes.get_yticklabels()]
    assert 0 <= min(box.x0 for box in boxes) < 0.25 * dots
    assert figure.get_supxlabel() == f"jee-koren-2004-pid / {SOFTER} [1]"
    (words,) = [text for text in figure.texts if text.get_text() == figure.get_supxlabel()]
    box = words.get_window_extent()
    assert box.x0 > 0
    assert box.y1 < min(x.get_window_extent().y0 for x in axes.get_xticklabels() if x.get_text())
    for each in figure.axes:
        assert len(read_apart(figure, each)) == 3


def test_numbers_of_the_errors_of_machines_stand_apart(spindles):
    figure = machines(spindles)
    told = read_apart(figure, figure.axes[0])
    assert [float(number) for number in told] == sorted(map(float, told))


def test_a_small_picture_says_the_same(spindles):
    figure = motions(spindles.bouts[0], panels(spindles.bouts[0]))
    whole, small = image(figure, "svg").decode(), small_address(figure)
    assert len(small) < 0.6 * len(address(figure))
    picture = unquote(small.removeprefix("data:image/svg+xml,"))
    one, other = (ElementTree.fromstring(text) for text in (whole, picture))
    assert [x.text for x in one.iter(TEXT)] == [x.text for x in other.iter(TEXT)]
    curves = zip(one.iter(PATH), other.iter(PATH), strict=True)
    for before, after in curves:
        exact, rounded = (numbers(path.get("d", "")) for path in (before, after))
        np.testing.assert_allclose(rounded, exact, atol=0.00501)


TEXT, PATH = "{http://www.w3.org/2000/svg}text", "{http://www.w3.org/2000/svg}path"


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
