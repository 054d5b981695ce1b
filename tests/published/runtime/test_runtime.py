"""The numpy runtime: by hand, and against the compiled loop."""

import numpy as np
import pytest
from lifted import controller_of

from hfc_design.controllers.hierarchical.root import Adaptation
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.runtime import Controller
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop


def replayed(design, scenario):
    """Commands of the compiled loop and of the runtime that sees the same signals."""
    controller, gains = controller_of(design)
    scenario = load_scenario(scenario, ["simulation.duration_s=1.0"])
    loop = closed_loop(scenario, controller)
    machines = simulate.one_machine(scenario.plant.values())
    _, (motion,) = simulate.trajectory(loop, machines, scenario.samples(), gains)
    state = motion.state
    signals = {
        "error": motion.error,
        "error_rate": motion.error_rate,
        "deflection": state.rotor_angle - state.spindle_angle,
        "deflection_rate": state.rotor_velocity - state.spindle_velocity,
        "spindle_velocity": state.spindle_velocity,
    }
    rows = np.stack(list(signals.values()))[..., 0].T.tolist()
    runtime = Controller(design)
    found = [runtime.step(dict(zip(signals, row, strict=True))) for row in rows]
    return motion.command[:, 0], np.array(found), runtime, dict(zip(signals, rows[0], strict=True))


@pytest.mark.parametrize("scale", [None, 500.0])
@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "lin-lee-1999-table-2"])
def test_equals_the_loop_where_the_root_adapts(name, scale):
    design = load_design(name)
    record = Adaptation(k_c=1e-3, largest_move=0.5, error_scale=scale)
    controller = design.controller.model_copy(update={"adaptation": record})
    adapting = design.model_copy(update={"controller": controller})
    compiled, found, *_ = replayed(adapting, "c-axis-ramp-cutting")
    np.testing.assert_allclose(found, compiled, rtol=1e-12, atol=1e-12)
    fixed, *_ = replayed(design, "c-axis-ramp-cutting")
    assert np.abs(compiled - fixed).max() > 1.0  # it did learn
