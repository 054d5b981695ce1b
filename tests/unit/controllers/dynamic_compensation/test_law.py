"""Dynamic compensation: five principles of LG09, the edge of its dead zone, what is told."""

import json

import numpy as np
import pytest
from two_axes import SILENT, ZONE, compensated
from wording import refused

from hfc_design.files.design import design_json, parse_design
from hfc_design.runtime import Machine


def compensation(errors, rates, **changes):
    """What the axes are commanded when nothing else commands them."""
    each = zip("xy", errors, rates, strict=True)
    told = {axis: {"error": e, "reference_rate": r, "error_rate": 0.0} for axis, e, r in each}
    return np.array([*Machine(compensated(**changes)).step(told).values()])


def test_by_hand():
    """le = 5, its share beyond the zone 0.9; half the speed: (2 x 3, 3 x 4) x 0.45."""
    found = compensation((3.0, 4.0), (30.0, -40.0))
    np.testing.assert_allclose(found, [2.0 * 3.0 * 0.45, 3.0 * 4.0 * 0.45], rtol=1e-14)


def test_it_is_zero_where_the_planned_velocity_is():  # the first principle
    assert not compensation((3.0, 4.0), (0.0, 0.0)).any()


def test_it_is_zero_at_the_dead_zone_and_has_no_jump_there():  # the second
    edge = ZONE * np.array([0.6, 0.8])
    assert not compensation(edge * (1.0 - 1e-12), (60.0, 80.0)).any()
    assert not compensation(0.1 * edge, (60.0, 80.0)).any()
    for near in (1e-3, 1e-6, 1e-9):
        beyond = compensation((1.0 + near) * edge, (60.0, 80.0))
        np.testing.assert_allclose(beyond, near * edge * [2.0, 3.0], rtol=1e-6)


def test_it_grows_as_the_path_gets_faster_and_falls_as_it_gets_slower():  # the third, the fourth
    rates = [(0.6 * v, 0.8 * v) for v in (0.0, 20.0, 50.0, 90.0, 100.0)]
    found = np.array([compensation((3.0, 4.0), rate) for rate in rates])
    assert (np.diff(found, axis=0) > 0.0).all()
    np.testing.assert_allclose(found, np.outer([0.0, 0.2, 0.5, 0.9, 1.0], found[-1]), rtol=1e-14)


def test_its_peak_is_at_the_programmed_velocity():  # the fifth
    peak = compensation((3.0, 4.0), (60.0, 80.0))
    np.testing.assert_array_equal(compensation((3.0, 4.0), (90.0, 120.0)), peak)


def test_only_the_axes_of_the_path_tell_its_speed():
    found = compensation((3.0, 4.0), (30.0, 1e3), path_axes=["x"])
    np.testing.assert_allclose(found, np.array([6.0, 12.0]) * 0.9 * 0.3, rtol=1e-14)


def test_it_is_added_to_any_controllers_and_kept_within_their_limits():
    pid = {"kind": "pid", "pid": {"k_p": 1.0, "k_i": 0.0, "k_d": 0.0}}
    own = {"kind": "per-axis", "axes": {"x": pid, "y": SILENT}}
    found = compensation((3.0, 4.0), (60.0, 80.0), inner=own)
    np.testing.assert_allclose(found, [3.0 + 5.4, 10.8], rtol=1e-14)
    found = compensation((3.0, -4.0), (60.0, 80.0), inner=own, limit=7.0)
    np.testing.assert_array_equal(found, [7.0, -7.0])


def test_what_is_inside_remembers():
    pid = {"kind": "pid", "pid": {"k_p": 0.0, "k_i": 10.0, "k_d": 0.0}}
    machine = Machine(compensated(inner=pid))
    told = {axis: {"error": 0.2, "reference_rate": 0.0, "error_rate": 0.0} for axis in "xy"}
    found = [machine.step(told)["x"] for _ in range(3)]
    assert found == pytest.approx([0.02, 0.04, 0.06])


@pytest.mark.parametrize(
    "changes",
    [
        {"k_p": {"y": 1.0, "x": 1.0}},
        {"path_axes": ["z"]},
        {"path_axes": ["x", "x"]},
        {"inner": SILENT | {"sample_time_s": 0.1}},
        {"dead_zone": 0.0},
        {"programmed_speed": -1.0},
    ],
)
def test_what_does_not_fit_is_told(changes):
    data = json.loads(design_json(compensated()))
    data["controller"] |= changes
    with refused() as found:
        Machine(parse_design(json.dumps(data), "mine.json"))
    assert f"controller.{next(iter(changes))}" in found.refusal
