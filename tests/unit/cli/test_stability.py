"""``hfc stability`` and its figure."""

import json
from functools import partial

import numpy as np
import pytest
from run_folders import hfc as command

from hfc_design.stability.report import stability_figure
from hfc_design.stability.stable_range import stable_range

hfc = partial(command, "stability")


def test_json_holds_the_range():
    done = hfc("--gain", 40, "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["drive"] == {"gain": 40.0, "time_constant": 0.055, "sample_time": 0.01}
    assert found["k1_printed"] == pytest.approx(6.3933, abs=5e-5)
    assert found["k1_bound"] == found["k1_linear"]
    assert found["a"] == pytest.approx(0.941208, abs=5e-7)
    assert len(found["k2_bounds"]) == 5
    bounds = [point["k2"] for point in found["k2_bounds"]]
    assert bounds == sorted(bounds, reverse=True)


def test_figure_runs_through_the_independent_values():
    points = {"Table 3": (32 / 21, 16 / 3), "steep": (6.0, 9.0)}
    axes = stability_figure(stable_range(28.3, 0.055, 0.01), points).axes[0]
    assert axes.get_xlabel() == "$K_1$ [unit/BLU]"
    assert axes.get_ylabel() == "$K_2$ [unit/BLU]"
    lines = {line.get_label(): line.get_xydata() for line in axes.lines}
    bound = axes.lines[0].get_xydata()
    drawn = np.interp([1.52, 2.711, 4.518, 6.3255], *bound.T)
    np.testing.assert_allclose(drawn, [9.412, 8.997, 5.895, 3.143], atol=2e-3)
    assert np.interp(8.133, *lines["printed"].T) == pytest.approx(0.952, abs=2e-3)
    assert lines["printed"][-1] == pytest.approx([9.0364, 0.0], abs=5e-5)
    assert lines["linear limit"][0, 0] == pytest.approx(bound[-1, 0])
    for name, point in points.items():
        np.testing.assert_array_equal(lines[name], [point])
    shade = axes.collections[0].get_paths()[0]
    assert [shade.contains_point(point) for point in points.values()] == [True, False]
