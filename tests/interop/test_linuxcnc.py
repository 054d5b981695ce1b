"""The exported component in LinuxCNC's HAL, without hardware and without a real-time kernel."""

import subprocess

import feed_oracle
import made_up
import numpy as np
import pytest
from hal_session import exported, open_loop, with_controller

from hfc_design import runtime
from hfc_design.files.design import design_json, named_design, with_learned
from hfc_design.formats import code, linuxcnc
from hfc_design.formats.reading import Wish, imported

#: HAL's text has six decimals.
TEXT = 5.001e-7


def around(design, count):
    """Random signals for a design of the C-axis: its universe, corners, centre and beyond."""
    random = np.random.default_rng(1)
    inputs = getattr(design.controller, "inputs", ())
    reach = {item.name.removeprefix("previous_"): 1.0 / item.scale for item in inputs}
    signals = {}
    for name in code.signals(design):
        values = random.uniform(-1.3, 1.3, count)
        values[:7] = [0.0, 1.0, 1.0, -1.0, -1.0, 30.0, -30.0]
        signals[name] = reach.get(name, 0.1) * values
    return signals


@pytest.mark.parametrize(
    "design",
    [
        named_design("lin-lee-1999-table-1"),
        made_up.hierarchy(4, adaptation={"largest_move": 0.7, "k_c": 0.01}),
        named_design("pd-only"),
        made_up.limited(made_up.linear("lqi", 6), 300.0),
        made_up.limited(made_up.scheduling(5), 300.0),
    ],
    ids=["table-1", "adapts", "pd", "lqi", "scheduling"],
)
def test_c_axis_controllers_do_what_the_runtime_does(hal, design, tmp_path):
    folder = exported(hal, design, tmp_path / "out")
    signals = around(design, 2000)
    velocity = signals.setdefault("spindle_velocity", np.zeros(2000))
    pins = {
        "reference": signals["error"] + 0.01,
        "spindle-angle": np.full(2000, 0.01),
        "reference-rate": signals["error_rate"] + velocity,
        "spindle-velocity": velocity,
    }
    told = {"deflection", "deflection_rate", "current", "reference_acceleration"}
    for name in signals.keys() & told:
        pins[name.replace("_", "-")] = signals[name]
    found = open_loop(hal, folder, 1000000, pins)

    signals["error"] = pins["reference"] - pins["spindle-angle"]
    signals["error_rate"] = pins["reference-rate"] - velocity
    signals["reference_rate"] = pins["reference-rate"]
    controller = runtime.Controller(design)
    for k, (error, command, fault) in enumerate(found):
        wanted = controller.step({name: float(values[k]) for name, values in signals.items()})
        assert (abs(error - signals["error"][k]), fault) <= (TEXT, 0)
        assert abs(command - wanted) <= 1e-6


@pytest.mark.parametrize(
    "design",
    [
        named_design("jee-koren-2004-aflc"),
        made_up.fuzzy("flc", 3, form="PI"),
    ],
    ids=["aflc", "random-flc"],
)
def test_feed_drive_controllers_do_what_the_runtime_does(hal, design, tmp_path):
    design = with_controller(design, sample_time_s=0.001)  # ten times as fast, to wait less
    folder = exported(hal, design, tmp_path / "out")
    error = np.array(feed_oracle.errors(2000, 5))
    pins = {"reference": error + 7.0, "position": np.full(2000, 7.0)}
    sample = {"error": error}
    if "controller.velocity " in (folder / "controller.hal").read_text():
        sample["velocity"] = pins["velocity"] = 300.0 * np.sin(np.arange(2000))
    found = open_loop(hal, folder, 1000000, pins)

    controller = runtime.Controller(design)
    for k, (seen, command, fault) in enumerate(found):
        wanted = controller.step({name: float(values[k]) for name, values in sample.items()})
        assert (seen, fault) == (error[k], 0)
        assert abs(command - wanted) <= 1e-6


def test_a_pid_rests_until_it_is_enabled_and_winds_up_at_no_limit(hal, tmp_path):
    """By hand: at the limit the sum stays 0, and the jump of -55 in sample 210 drives beyond it."""
    design = with_controller(named_design("jee-koren-2004-pid"), sample_time_s=0.001)
    folder = exported(hal, design, tmp_path / "out")
    error, enable = np.repeat([50.0, -5.0], [210, 90]), np.ones(300)
    enable[:10] = enable[250:260] = 0
    pins = {"reference": error, "position": np.zeros(300), "enable": enable}
    found = open_loop(hal, folder, 1000000, pins, "setp controller.limit 30", kinds="ffb")
    k_p, k_i = design.controller.pid.k_p, design.controller.pid.k_i * 0.001
    again = -5.0 * (k_p + k_i * np.arange(1, 41))
    wanted = np.concatenate([[0.0] * 10, [30.0] * 200, [-30.0], again[:39], [0.0] * 10, again])
    assert abs(found[:, 1] - wanted).max() <= 1e-6


def test_enable_limit_and_what_is_not_finite(hal, tmp_path):
    """The limit is one as in the design: it winds nothing up."""
    own = {"sample_time_s": 0.001, "integral_gain": 40.0}
    design = with_controller(named_design("jee-koren-2004-aflc"), **own)
    folder = exported(hal, design, tmp_path / "out")
    error = np.array(feed_oracle.errors(600, 3))
    enable = np.ones(600)
    enable[300:310] = 0
    pins = {"reference": error.copy(), "position": np.zeros(600), "enable": enable}
    pins["reference"][500] = np.nan
    found = open_loop(hal, folder, 1000000, pins, "setp controller.limit 20", kinds="ffb")
    design = made_up.limited(design, 20.0)
    controller = runtime.Controller(design)
    for k, (_, command, fault) in enumerate(found):
        wanted = 0.0
        if not enable[k]:
            controller = without_past(design, controller)
        elif k != 500:
            wanted = controller.step({"error": float(error[k])})
        assert fault == (k == 500)
        assert abs(command - wanted) <= 1e-6
    assert (abs(found[:, 1]) == 20.0).any()


def without_past(design, controller):
    """One that keeps what it has learnt and nothing else."""
    return runtime.Controller(with_learned(design, controller.adapted(), {}))


def test_what_is_learnt_outlives_a_session(hal, tmp_path):
    """Saved by one, loaded by the next, imported here, all to the seven digits that HAL prints."""
    design = with_controller(named_design("jee-koren-2004-aflc"), sample_time_s=0.001)
    folder = exported(hal, design, tmp_path / "out")
    error = np.array(feed_oracle.errors(600, 3))
    pins = {"reference": error, "position": np.zeros(600), "save": np.arange(600) == 599}
    open_loop(hal, folder, 1000000, pins, kinds="ffb", after="save param kept.hal")
    controller = runtime.Controller(design)
    for e in error.tolist():
        controller.step({"error": e})
    (tmp_path / "design.json").write_text(design_json(design))
    back = imported(folder / "kept.hal", Wish(like=str(tmp_path / "design.json"))).controller
    learnt = controller.adapted()
    table = np.array(learnt.rules.centroids)
    np.testing.assert_allclose(np.array(back.rules.centroids), table, rtol=1e-6)
    assert (table != np.array(design.controller.rules.centroids)).any()

    enable = np.arange(600) % 200 != 0
    pins = {"reference": error, "position": np.zeros(600), "enable": enable}
    pins |= {"load": np.ones(600), "forget": np.arange(600) == 500}
    found = open_loop(hal, folder, 1000000, pins, "source kept.hal", kinds="ffbbb")
    controller = runtime.Controller(with_learned(design, back, {}))
    for k, (_, command, fault) in enumerate(found):
        controller = runtime.Controller(design) if k == 500 else controller
        controller = controller if enable[k] else without_past(design, controller)
        wanted = controller.step({"error": float(error[k])}) if enable[k] else 0.0
        assert abs(command - wanted) <= 1e-6
        assert not fault


def test_a_thread_of_another_period_is_a_fault(hal, tmp_path):
    design = named_design("lin-lee-1999-table-1")
    folder = exported(hal, design, tmp_path / "out")
    found = open_loop(hal, folder, 2000000, {"reference": np.ones(20)})
    assert (found == [1.0, 0.0, 1.0]).all()


def test_longest_names_fit_into_hal(hal, tmp_path):
    name = "a.name-of_64-characters-" + "x" * 40
    design = named_design("lin-lee-1999-table-1").model_copy(update={"name": name})
    folder = exported(hal, design, tmp_path / "out")
    component = linuxcnc.component_name(design)
    (folder / "names.hal").write_text(
        f"loadrt {component}\nloadrt hfc_c_axis\nshow pin\nshow param\n"
    )
    shown = hal.run(folder, "names.hal")
    prefix = component.replace("_", "-")
    assert f"{prefix}.0.spindle-velocity" in shown
    assert "hfc-c-axis.0.friction-inverse-stribeck-velocity" in shown


def test_a_session_that_hangs_is_ended(hal, tmp_path):
    (tmp_path / "hangs.hal").write_text(
        "loadrt sampler depth=10 cfg=f\nloadusr -w halsampler -n 9 out.txt\n"
    )
    with pytest.raises(subprocess.TimeoutExpired):
        hal.run(tmp_path, "hangs.hal", timeout=3)
    (tmp_path / "next.hal").write_text("show comp\n")
    assert "sampler" not in hal.run(tmp_path, "next.hal")
