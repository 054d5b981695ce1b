"""hfc plot of several: motions of designs, and searches, over one another."""

import numpy as np
import pytest
from design_files import written
from run_folders import hfc, searched

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.overlaid import motions
from hfc_design.simulation.evaluating import evaluate

SHORT = "simulation.duration_s=0.1"


def evaluated(scenario, *designs):
    where = load_scenario(scenario, [SHORT])
    return {one.name: evaluate(one, where) for one in designs}


def lines(axes):
    return {line.get_label(): line for line in axes.lines}


def test_curves_of_one_axis_are_what_was_simulated():
    soft = load_design("pd-only", {"controller.pd.kp": 900.0, "name": "soft"})
    found = evaluated("c-axis-ramp", load_design("pd-only"), soft)
    figure = motions(found, "ramp")
    names = [axes.get_ylabel() for axes in figure.axes]
    assert names == ["angle [rad]", "error [mrad]", "deflection [mrad]", "voltage [V]"]
    angle, error, _, voltage = map(lines, figure.axes)
    for name, one in found.items():
        axis = one.axes[0]
        assert angle[name].get_ydata() == pytest.approx(axis.motion.state.spindle_angle)
        assert error[name].get_ydata() == pytest.approx(1e3 * axis.motion.error)
        assert voltage[name].get_ydata() == pytest.approx(axis.motion.command)
    assert angle["reference"].get_ydata()[-1] == pytest.approx(0.02 * 0.099)  # LL section 4.1


def test_a_path_has_contour_errors_and_every_axis():
    pid = "jee-koren-2004-pid"
    soft = load_design(pid, {"controller.pid.k_p": 1.0, "name": "soft"})
    found = evaluated("feed-drive-line", load_design(pid), soft)
    figure = motions(found, "line")
    names = [axes.get_title(loc="right") for axes in figure.axes]
    each = [f"{axis} {what}" for axis in "xy" for what in ("position", "error", "command")]
    assert [name.partition(" [")[0] for name in names] == ["contour error", *each]
    for name, one in found.items():
        assert lines(figure.axes[0])[name].get_ydata() == pytest.approx(one.contour.error)


def test_what_runs_away_does_not_hide_the_others():
    wild = load_design("pd-only", {"controller.pd.kd": 1e9, "name": "wild"})
    kept, away = evaluated("c-axis-ramp", load_design("pd-only"), wild).values()
    assert away.diverged
    figure = motions({"kept": kept, "away": away}, "")
    low, high = figure.axes[1].get_ylim()
    error = 1e3 * kept.axes[0].motion.error
    assert (low, high) == pytest.approx((error.min(), error.max()), abs=0.06 * np.ptp(error))
    assert "away (diverged)" in lines(figure.axes[1])


def test_commands(tmp_path):
    out = tmp_path / "a.pdf"
    soft = written(tmp_path / "soft.json", name="soft")
    done = hfc("plot", "pd-only", soft, "motion", "--set", SHORT, "--out", out)
    assert (done.exit_code, done.stdout) == (0, f"{out}\n")
    assert out.read_bytes().startswith(b"%PDF")
    folders = [searched(tmp_path / name, 1.0) for name in ("a", "b")]
    picture = tmp_path / "b.svg"
    assert hfc("plot", *folders, "convergence", "--out", picture).exit_code == 0
    assert "best fitness so far" in picture.read_text()
