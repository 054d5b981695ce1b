"""``hfc stability`` and its figure."""

import json
from functools import partial

import made_up
import numpy as np
import pytest
from run_folders import hfc as command

from hfc_design.calls.stability import stability
from hfc_design.files.design import design_json
from hfc_design.stability.stable_range import stable_range

hfc = partial(command, "stability")


def test_a_design_is_placed_in_the_range_of_its_own_drive():
    data = json.loads(hfc("jee-koren-2004-aflc", "--json").stdout)
    points = list(data["points"].values())
    # Table 3 with rule base I by hand: 32 at 21 BLU, (16 - 8) at 1.5 BLU; with its edges the 32
    # begin at 19 BLU and the step from PS to PM at 1 BLU; then the built-in limit.
    assert [point["k1"] for point in points] == pytest.approx([32 / 21, 32 / 19, 4.5])
    assert [point["k2"] for point in points] == pytest.approx([8 / 1.5, 8.0, 5.9])
    assert all(point["inside"] for point in points)
    assert data["k1_printed"] == pytest.approx(9.0364, abs=5e-5)


LQI = made_up.linear("lqi", 5, "feed-drive")


def linear(folder, **changes):
    """A design file of a PD on the feed drive K = 40, tau = 0.055 without friction."""
    parts = ("start", "slope", "curvature")
    own = {f"{way}_{part}": 0.0 for way in ("positive", "negative") for part in parts}
    data = json.loads(design_json(LQI))
    data["plant"]["parameters"] = {"gain": 40.0, "coulomb": 0.0, **own, **changes}
    data["controller"] = {"kind": "pid+ff", "sample_time_s": 0.01, "kp": 1.2}
    where = {"name": "plain", "plant": {"name": "feed-drive"}}
    where["simulation"] = {"sample_time_s": 0.01}
    data["provenance"] = {"scenario": where | {"reference": {"kind": "ramp", "velocity": 100.0}}}
    (folder / "mine.json").write_text(json.dumps(data))
    return folder / "mine.json"


def points(*arguments):
    """Rows of the loops that have margins."""
    found = json.loads(hfc(*arguments, "--json").stdout)
    return [one for one in found["points"] if "why" not in one]


def test_the_margin_of_a_linear_design_is_that_of_the_published_formula(tmp_path, monkeypatch):
    """K_1 up to which the linear loop u = K_1 e is stable (JK04 eq. 19), over the kp of the PD."""
    limit = stable_range(40.0, 0.055, 0.01).k1_linear
    found = points(linear(tmp_path))
    assert [one["point"] for one in found] == ["100 BLU/s"]
    for one in found:
        assert one["stable"]
        assert one["gain_up"] == pytest.approx(limit / 1.2, rel=1e-6)
        assert one["gain_down"] is None
        low, high = one["band"]["gain_up"]
        assert low < one["gain_up"] < high
        # A position that is 1 / kp of a load off asks for a command that takes it back.
        assert one["compliance_static"] == pytest.approx(1.0 / 1.2, rel=1e-4)
    for width in (60, 80, 120):
        monkeypatch.setenv("COLUMNS", str(width))
        told = hfc(linear(tmp_path)).stdout
        assert f"{limit / 1.2:.3g}" in told
        assert max(map(len, told.splitlines())) <= width


@pytest.mark.parametrize("delay", [0.5, 1.0, 1.25])
def test_the_delay_of_the_drive_is_in_the_loop(delay, tmp_path):
    """Whole samples turn it; of a part the drive takes the old and the new command in the mean."""
    own, late = (
        stability(linear(tmp_path), {"limits.delay_samples": k}).rows[-1] for k in (0.0, delay)
    )
    angles = np.linspace(0.01, 3.1, 30)
    whole, part, back = int(delay), delay % 1.0, np.exp(-1j * angles)
    expected = own.loop.transfer(angles) * back**whole * (1.0 - part + part * back)
    np.testing.assert_allclose(late.loop.transfer(angles), expected, rtol=1e-9)
    if not part:
        left = own.numbers["delay_samples"] - delay
        assert late.numbers["delay_samples"] == pytest.approx(left, abs=1e-9)


def test_each_axis_has_margins_of_its_own(tmp_path):
    data = json.loads(linear(tmp_path).read_text())
    data["plant"]["axes"] = {"x": {}, "y": {"gain": 20.0}}
    where = data["provenance"]["scenario"]
    where["plant"]["axes"] = {"x": {}, "y": {}}
    where["reference"] = {"kind": "circle", "radius_mm": 10.0, "feed_mm_min": 700.0}
    (tmp_path / "two.json").write_text(json.dumps(data))
    x, y = ({**one} for one in points(tmp_path / "two.json")[:2])
    assert (x["axis"], y["axis"]) == ("x", "y")
    assert y["gain_up"] == pytest.approx(2.0 * x["gain_up"], rel=1e-6)


def test_a_loop_that_friction_holds_says_so_at_rest_in_a_line():
    found = json.loads(hfc("emps-cascade", "--json").stdout)
    rest, moving = found["points"]
    assert "friction" in rest["why"]
    assert moving["stable"]
    assert found["worst"]["sensitivity"]["at"] == moving["point"]
