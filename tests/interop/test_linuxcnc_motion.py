"""The exported closed loop in LinuxCNC's HAL moves as the simulator does."""

import jax
import made_up
import numpy as np
import pytest
from connections import CASES, made
from hal_session import exported as exported_bare

from hfc_design import runtime
from hfc_design.files.design import design_json, named_design
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import load_scenario, scenario_of
from hfc_design.runs.individuals import design_with
from hfc_design.simulation.evaluating import evaluate
from plants import feed_drive


def exported(hal, design, folder):
    """As ``hfc export`` writes it: its pins are what the machine's sensors tell."""
    return exported_bare(hal, design, folder, bare=False)


def motion(folder):
    """(axes, 3, samples) error, command, position of the exported closed loop."""
    rows = np.loadtxt(folder / "motion.txt")
    return rows.T.reshape(-1, 3, len(rows))


def test_c_axis_moves_as_in_the_simulator(hal, tmp_path):
    design = named_design("lin-lee-1999-table-2")
    folder = exported(hal, design, tmp_path / "out")
    hal.run(folder, "loop.hal")
    (axis,) = evaluate(design, own_scenario(design, design.name)).axes
    ((error, command, position),) = motion(folder)
    assert position.shape == axis.motion.error.shape  # all of the scenario
    assert abs(position - axis.motion.state.spindle_angle).max() <= 1e-6
    assert abs(error - axis.motion.error).max() <= 1e-6
    # HAL holds the cutting load for a sample, which the simulator integrates over
    assert abs(command - axis.motion.command).max() <= 5e-4


def test_a_table_that_the_design_carries_is_followed_as_in_the_simulator(hal, tmp_path):
    """A measured motion, whose file is gone by then: corners, a rest, the load from a file too."""
    rows = [(0.0, 0.0), (0.3, 0.006), (0.5, 0.006), (0.9, -0.002), (1.0, -0.002)]
    (tmp_path / "way.csv").write_text("".join(f"{t},{x}\n" for t, x in rows))
    (tmp_path / "cut.csv").write_text("time_s,load_Nm\n0,0\n0.6,4\n1.2,4\n")
    settings = {"reference": {"kind": "csv", "file": "way.csv"}, "load": {"file": "cut.csv"}}
    settings |= {"name": "measured", "simulation": {"duration_s": 1.5}}
    scenario = scenario_of(settings, "mine.toml", tmp_path)
    controller = named_design("lin-lee-1999-table-1").controller.model_dump(mode="json")
    (tmp_path / "design.json").write_text(design_json(design_with(controller, scenario)))
    wanted = evaluate(load_design(tmp_path / "design.json"), scenario).axes[0].motion
    for file in ("way.csv", "cut.csv"):
        (tmp_path / file).unlink()
    folder = exported(hal, load_design(tmp_path / "design.json"), tmp_path / "out")
    hal.run(folder, "loop.hal")
    ((error, command, position),) = motion(folder)
    assert position.shape == (1500,)
    assert abs(position - wanted.state.spindle_angle).max() <= 1e-6
    assert abs(error - wanted.error).max() <= 1e-6
    assert abs(command - wanted.command).max() <= 5e-4  # the load is held for a sample


@pytest.mark.parametrize("name", ["pd-only", "lin-lee-1999-table-2", "huang-soc"])
def test_sensors_and_converter_of_the_scenario_are_in_the_component(hal, name, tmp_path):
    """Differences of readings in steps, an observer, a converter: all but noise."""
    assert any("velocity" in change for change in CASES[name])
    design, scenario = made(name)
    folder = exported(hal, design, tmp_path / "out")
    hal.run(folder, "loop.hal")
    for (error, command, _), axis in zip(
        motion(folder), evaluate(design, scenario).axes, strict=True
    ):
        size = abs(axis.motion.command).max()
        assert np.median(abs(command - axis.motion.command)) <= 1e-4 * size
        own = axis.sensed()["error"]
        assert np.median(abs(error - own)) <= 1e-4 * abs(own).max()


def test_a_fast_c_axis_moves_as_in_the_simulator(hal, tmp_path):
    """Beyond 1 rad/s and back: its bristles are implicit, explicit and implicit again."""
    sine = {"kind": "sine", "amplitude": 0.06, "frequency_rad_s": 10.0}
    scenario = load_scenario({"simulation": {"duration_s": 2.0}, "reference": sine})
    told = {"scenario": scenario.model_dump(mode="json", exclude_none=True)}
    design = named_design("pd-only").model_copy(update={"provenance": told})
    folder = exported(hal, design, tmp_path / "out")
    hal.run(folder, "loop.hal")
    (axis,) = evaluate(design, scenario).axes
    assert abs(axis.motion.state.spindle_velocity).max() > 1.0
    ((_, command, position),) = motion(folder)
    assert abs(position - axis.motion.state.spindle_angle).max() <= 1e-6
    assert abs(command - axis.motion.command).max() <= 2e-6


def sine_of(duration, *changes):
    """The beginning of a slow sine."""
    scenario = load_scenario("c-axis-sine", [f"simulation.duration_s={duration}", *changes])
    return scenario.model_dump(mode="json", exclude_none=True)


def test_a_linear_controller_moves_as_in_the_simulator(hal, tmp_path):
    """A PID with feed-forward of velocity, acceleration and Coulomb friction on a sine.

    The drive saturates, which the controller is not told of: its integral winds up in both.
    """
    ahead = {"velocity": 13.6, "acceleration": 28.0, "coulomb": 3.6, "coulomb_width": 0.003}
    own = {"kp": 1900.0, "ki": 1500.0, "kd": 450.0, "derivative_hz": 300.0}
    design = made_up.linear("pid+ff", 1)
    controller = design.controller.model_copy(
        update={**own, "signals": {}, "feed_forward": type(design.controller.feed_forward)(**ahead)}
    )
    told = {"scenario": sine_of(2.0, "limits.command=9")}
    design = design.model_copy(update={"controller": controller, "provenance": told})
    folder = exported(hal, design, tmp_path / "out")
    hal.run(folder, "loop.hal")
    (axis,) = evaluate(design, own_scenario(design, "pid")).axes
    ((error, command, position),) = motion(folder)
    assert (abs(command) == 9.0).sum() > 20  # what its converter gives
    command = np.clip(command, -9.0, 9.0)
    assert abs(position - axis.motion.state.spindle_angle).max() <= 1e-6
    assert abs(error - axis.motion.error).max() <= 1e-6
    assert abs(command - axis.motion.command).max() <= 1e-4


def test_a_command_of_a_limited_rate_moves_as_in_the_simulator(hal, tmp_path):
    """Of 10 V/s on a ramp, which begins with a jump of the velocity."""
    limits = {"limits.command": 40.0, "limits.command_rate": 10.0}
    design = load_design("pd-only", limits | {"controller.pd": {"kp": 900.0, "kd": 300.0}})
    design = design.model_copy(update={"provenance": {"scenario": sine_of(2.0)}})
    folder = exported(hal, design, tmp_path / "out")
    hal.run(folder, "loop.hal")
    (axis,) = evaluate(design, own_scenario(design, "pd")).axes
    ((_, command, position),) = motion(folder)
    moves = abs(np.diff(command, prepend=0.0))
    assert moves.max() <= 0.01 * (1.0 + 1e-9)
    assert np.isclose(moves, 0.01).sum() > 100
    assert abs(position - axis.motion.state.spindle_angle).max() <= 1e-6
    assert abs(command - axis.motion.command).max() <= 1e-4


def circle_of(design, duration):
    """``design`` made for the beginning of the circle of JK04."""
    scenario = load_scenario("feed-drive-circle", [f"simulation.duration_s={duration}"])
    return design.model_copy(
        update={"provenance": {"scenario": scenario.model_dump(mode="json", exclude_none=True)}}
    )


@pytest.mark.parametrize("encoder", ["position", "motor_position"])
def test_milling_tables_move_as_in_the_simulator(hal, encoder, tmp_path):
    """Across the backlash and into the flanks."""
    changes = ["simulation.duration_s=6", f"sensors.feedback={encoder}"]
    scenario = load_scenario("milling-table-circle", changes)
    told = {"scenario": scenario.model_dump(mode="json", exclude_none=True)}
    design = named_design("huang-pid").model_copy(update={"provenance": told})
    folder = exported(hal, design, tmp_path / "out")
    hal.run(folder, "loop.hal")
    axes = evaluate(design, scenario).axes
    for (error, command, position), axis in zip(motion(folder), axes, strict=True):
        assert abs(position - axis.motion.state.position).max() <= 1e-6
        assert abs(error - axis.sensed()["error"]).max() <= 1e-6
        assert abs(command - axis.motion.command).max() <= 1e-4


def test_published_aflc_moves_as_the_runtime_on_the_plant(hal, tmp_path):
    design = circle_of(named_design("jee-koren-2004-aflc"), 6.0)
    folder = exported(hal, design, tmp_path / "out")
    hal.run(folder, "loop.hal")
    scenario = own_scenario(design, "aflc")
    move = jax.jit(feed_drive.step)
    with jax.enable_x64(True):
        for happens, parameters, seen in zip(
            scenario.samples().axes, scenario.plant.values(), motion(folder), strict=True
        ):
            fixed = feed_drive.coefficients(parameters)
            state = feed_drive.FeedDriveState(0.0, 0.0)
            controller = runtime.Controller(design)
            for k, reference in enumerate(happens.reference):
                error = float(reference) - round(float(state.position))
                command = controller.step({"error": error})
                wanted = (error, command, float(state.position))
                assert abs(seen[:, k] - wanted).max() <= 1e-6
                state = move(
                    fixed, state, float(min(max(round(command), -128), 127)), (0.0,) * 3, 0.01
                )
