"""What a motion needs of a drive: against the equation of the stage's motion."""

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.why_not import needed

MOVE = {"kind": "trapezoidal", "distance": 40.0, "velocity": 500.0, "acceleration": 8e3}


@pytest.mark.parametrize(("way", "load"), [(1.0, 0.0), (-1.0, 0.0), (-1.0, 30.0)])
def test_a_move_of_the_stage_by_hand(way, load):
    """u g = m a + F_v v + (F_c + offset) forwards, - F_c + offset backwards, + load [V, N, m]."""
    reference = MOVE | {"distance": way * MOVE["distance"]}
    where = {"name": "move", "plant": {"name": "positioning-stage"}, "reference": reference}
    scenario = load_scenario(where | {"load": {"constant": load}})
    (axis,), samples = scenario.plant.each(), scenario.samples().axes[0]
    p = axis.parameters
    (command, limit), (speed, top) = needed(axis.drive, p, samples, 7.0, 1e-3)
    rate, rising = 1e-3 * samples.reference_rate, 1e-3 * samples.reference_acceleration
    friction = np.sign(rate) * p.coulomb_friction + p.viscous_friction * rate
    friction += p.viscous_asymmetry * p.viscous_friction * np.abs(rate)
    force = p.mass * rising + friction + load + p.offset * (rate != 0.0)
    assert command == pytest.approx(np.abs(force / p.amplifier_gain).max(), rel=2e-3)
    assert limit == min(7.0, p.highest_voltage)
    assert speed == pytest.approx(500.0)
    assert top == axis.drive.top_speed(p)
