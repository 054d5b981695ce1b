"""Curves for a page keep every extreme; ball bars show radii, contours what lies across a path."""

import base64
import re
from itertools import pairwise
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.projections.polar import PolarAxes

from hfc_design.motion.trajectories import Circle
from hfc_design.pictures.column import in_column
from hfc_design.pictures.figure import WIDTH, framed
from hfc_design.pictures.files import address, image, small_address
from hfc_design.report import overlaid
from hfc_design.report.comparison.plots import (
    BAR,
    _few_decades,
    contours,
    machines,
    motions,
)
from hfc_design.report.comparison.ratios import ratios
from hfc_design.report.comparison.traces import data, extremes, panels
from hfc_design.report.contours import SHARE
from hfc_design.report.errors import errors


@pytest.mark.parametrize("count", [1, 7, 1200, 1201, 10_000, 12_345])
def test_no_extreme_is_lost(count):
    values = np.random.default_rng(count).normal(size=count)
    found, size = extremes(values)
    assert len(found) <= 1200 or size == 1
    assert found.min() == values.min()
    assert found.max() == values.max()
    for k in range(0, len(found) - 1, 2) if size > 1 else ():
        own = values[k // 2 * size : (k // 2 + 1) * size]
        assert set(found[k : k + 2]) == {own.min(), own.max()}
        if own.argmin() != own.argmax():
            assert (found[k] == own.min()) == (own.argmin() < own.argmax())


def test_designs_are_told_apart_without_colours_and_alike_in_all_figures(spindles):
    bout = spindles.bouts[0]
    found = {name: one.motion for name, one in bout.found.items()}
    moved, over, off = motions(bout, panels(bout)), overlaid.motions(found, ""), errors(found)
    dashes = [[line.get_linestyle() for line in x.axes[-1].lines[:2]] for x in (moved, over, off)]
    assert dashes == [["-", "--"]] * 3


def test_what_has_run_away_is_a_gap():
    values = np.arange(6000.0)
    values[3001:] = np.nan
    found, _ = extremes(values)
    assert np.nanmax(found) == 3000.0
    assert np.isnan(found[602:]).all()


def test_panels_have_what_moved_in_readable_units(spindles):
    bout = spindles.bouts[0]
    shown = panels(bout)
    units = [panel.label for panel in shown]
    assert units == ["error [mrad]", "voltage [V]", "velocity [mrad/s]", "position [mrad]"]
    name = "lin-lee-1999-table-1"
    axis = bout.found[name].motion.axes[0]
    np.testing.assert_allclose(shown[0].curves[name], 1e3 * axis.motion.error)
    place = 1e3 * axis.motion.state.spindle_angle
    np.testing.assert_allclose(shown[3].curves[name], place, atol=1e-9)
    np.testing.assert_allclose(shown[3].reference, 1e3 * axis.reference)


def test_data_of_the_page_read_back(spindles):
    bout = spindles.bouts[0]
    shown = panels(bout)
    found = data(bout, shown)
    assert found["step"] == pytest.approx(0.002)  # two values of four samples of 1 ms
    for panel, told in zip(shown, found["panels"], strict=True):
        assert told["label"] == panel.label
        assert told["names"] == list(panel.curves)
        assert (told["reference"] is None) == (panel.reference is None)
        for values, curve in zip(panel.curves.values(), told["curves"], strict=True):
            numbers = np.frombuffer(base64.b64decode(curve), "<f4")
            assert numbers.max() == np.float32(values.max())
            assert numbers.min() == np.float32(values.min())


def test_a_design_has_one_colour_in_every_picture(spindles):
    """On the page of a comparison, and where ``hfc plot`` draws the same designs."""
    bout = spindles.bouts[0]
    own = {name: one.motion for name, one in bout.found.items()}
    each = (motions(bout, panels(bout)), overlaid.motions(own, ""), errors(own))
    drawn = [[line.get_color() for line in figure.axes[0].lines[:2]] for figure in each]
    assert drawn[0] == drawn[1] == drawn[2]
    assert len(set(drawn[0])) == 2


def test_ball_bar_draws_the_radius(tables):
    bout = tables.bouts[0]
    figure, told = contours(bout)
    (axes,) = figure.axes
    assert isinstance(axes, PolarAxes)
    path = bout.found["jee-koren-2004-flc"].motion.contour
    assert isinstance(path.trajectory, Circle)
    largest = max(np.abs(x.motion.contour.error).max() for x in bout.found.values())
    division = next(x for x in (1, 2, 5, 10, 20, 50) if x >= largest / 2)
    assert told.startswith(f"A division, from one grey line to the next, is {division} BLU")
    assert f"({10 * division} µm)" in told  # of 10 µm each
    enlarged = BAR * path.trajectory.radius_mm / (0.01 * division)
    assert f"{enlarged:.0f} times enlarged" in told
    circle, first, second = axes.lines
    assert (circle.get_ydata() == 1.0).all()
    radius = np.hypot(*path.actual) / path.trajectory.radius_mm
    shown = first.get_ydata()
    assert shown.max() == pytest.approx(1 + enlarged * (radius.max() - 1))
    assert shown.min() == pytest.approx(1 + enlarged * (radius.min() - 1))
    assert second.get_label() == "jee-koren-2004-pid"
    assert contours(bout._replace(found={})) is None


def test_a_line_has_its_deviations_across_it(tables):
    bout = tables.bouts[1]
    figure, told = contours(bout)
    (axes,) = figure.axes
    path = bout.found["jee-koren-2004-pid"].motion.contour
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
    assert figure.get_supxlabel() == "jee-koren-2004-flc / jee-koren-2004-pid [1]"
    (words,) = [text for text in figure.texts if text.get_text() == figure.get_supxlabel()]
    box = words.get_window_extent()
    assert box.x0 > 0
    assert box.y1 < min(x.get_window_extent().y0 for x in axes.get_xticklabels() if x.get_text())
    for each in figure.axes:
        assert len(read_apart(figure, each)) == 3


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        (160.0, 750.0, [f"{100 * k}" for k in range(2, 8)]),  # of 1, 2, 5 there are too few
        (15.0, 420.0, ["20", "50", "100", "200"]),
        (0.9, 1.35, ["0.9", "1", "1.1", "1.2", "1.3"]),
        (12.0, 4e4, [rf"$\mathdefault{{10^{{{k}}}}}$" for k in (2, 3, 4)]),
    ],
)
def test_numbers_of_a_logarithmic_axis_stand_apart(low, high, told):
    figure = framed(1.5, top=0.1, left=1.0, right=0.5)
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    _few_decades(axes)
    assert read_apart(figure, axes) == told


def read_apart(figure, axes):
    """The numbers that are seen, none on another."""
    figure.draw_without_rendering()
    low, high = axes.get_xlim()
    ticks = [*axes.xaxis.get_major_ticks(), *axes.xaxis.get_minor_ticks()]
    shown = [x for x in ticks if x.label1.get_text() and low <= x.get_loc() <= high]
    labels = [x.label1 for x in sorted(shown, key=lambda x: x.get_loc())]
    boxes = [label.get_window_extent() for label in labels]
    assert len(boxes) > 2
    assert all(one.x1 + 2.0 < other.x0 for one, other in pairwise(boxes))
    return [label.get_text() for label in labels]


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
