"""``hfc stability`` and its figure."""

import json
import subprocess
import sys

import made_up
import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.design import design_json
from hfc_design.files.pairing import load_design
from hfc_design.stability.report import stability_figure
from hfc_design.stability.stable_range import stable_range


def hfc(*arguments):
    return CliRunner().invoke(main, ["stability", *(str(argument) for argument in arguments)])


def test_without_options_the_published_drive():
    done = hfc()
    assert done.exit_code == 0
    for part in ("0.0242364", "0.941208", "0.833753", "9.03643", "7.28786", "unit/BLU"):
        assert part in done.stdout


def test_json_holds_the_range():
    done = hfc("--gain", 40, "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["k1_printed"] == pytest.approx(6.3933, abs=5e-5)
    assert found["k1_bound"] == found["k1_linear"]
    assert found["a"] == pytest.approx(0.941208, abs=5e-7)
    assert len(found["k2_bounds"]) == 5
    bounds = [point["k2"] for point in found["k2_bounds"]]
    assert bounds == sorted(bounds, reverse=True)


def test_a_gain_divides_every_bound():
    one, ten = (json.loads(hfc("--gain", gain, "--json").stdout) for gain in (1, 10))
    for key in ("k1_bound", "k1_printed", "k1_linear", "k1_theorem"):
        assert one[key] == pytest.approx(10 * ten[key], rel=1e-12)
    assert one["k2_bounds"][2]["k2"] == pytest.approx(10 * ten["k2_bounds"][2]["k2"], rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--gain", "-1"], "--gain -1.0: has to be greater than 0"),
        (["--time-constant", "nan"], "--time-constant nan: has to be a finite number"),
        (["--sample-time", "0"], "--sample-time 0.0: has to be greater than 0"),
        (["--sample-time", "9"], "sample time / time constant = 163.636"),
        (["--plot", "range.gif"], "range.gif: a plot has to end in .png, .svg or .pdf"),
    ],
)
def test_mistakes_are_told_in_one_line(arguments, words):
    done = hfc(*arguments)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert done.stderr.startswith(f"hfc: {words}")
    assert done.stderr.count("\n") == 1


def test_a_gain_that_is_no_number():
    done = hfc("--gain", "much")
    assert done.exit_code == 2
    assert done.stderr == "hfc: --gain much: has to be a number\n"


def test_a_folder_that_is_not_there(tmp_path):
    done = hfc("--plot", tmp_path / "none" / "range.png")
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(("kind", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml")])
def test_plot_is_written(kind, start, tmp_path):
    path = tmp_path / f"range.{kind}"
    assert hfc("--plot", path).exit_code == 0
    assert path.read_bytes().startswith(start)


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


def test_numbers_alone_do_not_import_jax():
    code = (
        "import sys\nfrom hfc_design.cli import main\n"
        "try:\n    main(['stability', '--json'])\nfinally:\n    print('jax' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False"


def test_a_design_is_placed_in_the_range_of_its_own_drive():
    result = CliRunner().invoke(main, ["stability", "jee-koren-2004-aflc", "--json"])
    data = json.loads(result.stdout)
    points = list(data["points"].values())
    # Table 3 with rule base I by hand: 32 at 21 BLU, (16 - 8) at 1.5 BLU; with its edges the 32
    # begin at 19 BLU and the step from PS to PM at 1 BLU; then the built-in limit.
    assert [point["k1"] for point in points] == pytest.approx([32 / 21, 32 / 19, 4.5])
    assert [point["k2"] for point in points] == pytest.approx([8 / 1.5, 8.0, 5.9])
    assert all(point["inside"] for point in points)
    assert data["k1_printed"] == pytest.approx(9.0364, abs=5e-5)


def test_options_go_before_the_drive_of_the_design():
    command = ["stability", "jee-koren-2004-aflc", "--gain", "40", "--json"]
    data = json.loads(CliRunner().invoke(main, command).stdout)
    assert data["k1_printed"] == pytest.approx(6.3933, abs=5e-5)
    inside = [point["inside"] for point in data["points"].values()]
    assert inside == [True, False, False]  # 8 is more than the 6.66 at K_1 = 1.52


def test_a_table_for_another_plant_needs_a_drive(tmp_path):
    design = json.loads(design_json(load_design("jee-koren-2004-flc")))
    design["plant"] = {"name": "c-axis", "parameters": {}}
    (tmp_path / "mine.json").write_text(json.dumps(design))
    done = hfc(tmp_path / "mine.json")
    assert done.exit_code == 2
    assert done.stderr.startswith("hfc: design jee-koren-2004-flc is for the plant c-axis")
    assert "--time-constant" in done.stderr
    done = hfc(tmp_path / "mine.json", "--gain", 40, "--time-constant", 0.055, "--json")
    assert json.loads(done.stdout)["k1_printed"] == pytest.approx(6.3933, abs=5e-5)


@pytest.mark.parametrize("name", ["pd-only", "jee-koren-2004-pid", "no-such-design"])
def test_a_design_without_a_rule_table_is_refused(name):
    result = CliRunner().invoke(main, ["stability", name])
    assert result.exit_code == 2
    assert name in result.output
    assert "Traceback" not in result.output


LQI = made_up.linear("lqi", 5, "feed-drive")


def linear(folder, **changes):
    """A design file of a PD on the feed drive K = 40, tau = 0.055 without friction."""
    own = {"positive_start": 0.0, "positive_slope": 0.0, "positive_curvature": 0.0}
    data = json.loads(design_json(LQI))
    data["plant"]["parameters"] = {"gain": 40.0, "coulomb": 0.0, **own, **changes}
    data["controller"] = {"kind": "pid+ff", "sample_time_s": 0.01, "kp": 1.2}
    (folder / "mine.json").write_text(json.dumps(data))
    return folder / "mine.json"


def test_the_margin_of_a_linear_design_is_that_of_the_published_formula(tmp_path):
    """K_1 up to which the linear loop u = K_1 e is stable (JK04 eq. 19), over the kp of the PD."""
    limit = stable_range(40.0, 0.055, 0.01).k1_linear
    found = json.loads(hfc(linear(tmp_path), "--json").stdout)["axes"]["axis"]
    assert found["stable"]
    assert found["gain_up"] == pytest.approx(limit / 1.2, rel=1e-6)
    assert found["gain_down"] is None
    assert len(found["poles"]) == 3  # two of the drive, one of the filter; no integral
    told = hfc(linear(tmp_path))
    assert f"{limit / 1.2:.4g}" in told.stdout
    assert "delay margin [samples]" in told.stdout


def test_the_delay_of_the_drive_is_in_the_margins(tmp_path):
    """One sample less is left, and its lag is off the phase margin, at every crossing the same."""
    own, late = (
        json.loads(hfc(linear(tmp_path), "--change", f"limits.delay_samples={k}", "--json").stdout)
        for k in (0, 1)
    )
    (before,), (found,) = own["axes"].values(), late["axes"].values()
    assert found["delay"] == pytest.approx(before["delay"] - 1.0)
    crossing = np.radians(before["phase"]) / before["delay"]  # rad a sample
    assert found["phase"] == pytest.approx(before["phase"] - np.degrees(crossing))
    assert found["gain_up"] < before["gain_up"]
    told = " ".join(hfc(linear(tmp_path), "--change", "limits.delay_samples=1").stdout.split())
    assert "On the plant feed-drive." in told
    assert "With the delay of 1 sample that the drive has" in told


def test_each_axis_has_margins_of_its_own(tmp_path):
    data = json.loads(linear(tmp_path).read_text())
    data["plant"]["axes"] = {"x": {}, "y": {"gain": 20.0}}
    (tmp_path / "two.json").write_text(json.dumps(data))
    found = json.loads(hfc(tmp_path / "two.json", "--json").stdout)["axes"]
    assert list(found) == ["x", "y"]
    assert found["y"]["gain_up"] == pytest.approx(2.0 * found["x"]["gain_up"], rel=1e-6)


def test_a_linear_design_is_drawn_and_judged_on_its_own_drive(tmp_path):
    done = hfc(linear(tmp_path), "--plot", tmp_path / "loop.svg")
    assert done.exit_code == 0
    assert "frequency [Hz]" in (tmp_path / "loop.svg").read_text()
    refused = hfc(linear(tmp_path), "--gain", 40)
    assert refused.exit_code == 2
    assert refused.stderr.startswith("hfc: --gain: design made-up is judged on its own drive")


def test_a_gain_without_a_limit_does_not_flatten_the_picture():
    found = stable_range(28.3, 0.055, 0.01)
    near, free = (stability_figure(found, {"table": (3.0, k2)}).axes[0] for k2 in (16.0, 1000.0))
    assert 16.0 < near.get_ylim()[1] < 20.0
    assert free.get_ylim() == pytest.approx((0.0, 4 * 9.4125), abs=0.01)


def test_the_drive_is_named():
    done = hfc("--gain", 40, "--json")
    assert json.loads(done.stdout)["drive"] == {
        "gain": 40.0,
        "time_constant": 0.055,
        "sample_time": 0.01,
    }
    shown = " ".join(hfc("--gain", 40).stdout.split())
    assert "K [(BLU/s)/unit]" in shown
    assert "without friction" in shown
