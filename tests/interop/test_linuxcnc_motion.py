"""The exported closed loop in LinuxCNC's HAL moves as the simulator does."""

import jax
import numpy as np
import pytest
from connections import CASES, made
from hal_session import exported as exported_bare

from hfc_design import runtime
from hfc_design.files.design import named_design
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import load_scenario
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


def sine_of(duration, *changes):
    """The beginning of a slow sine."""
    scenario = load_scenario("c-axis-sine", [f"simulation.duration_s={duration}", *changes])
    return scenario.model_dump(mode="json", exclude_none=True)


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
