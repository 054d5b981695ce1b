"""What the controller is told and what becomes of its command, against SciPy and plain loops."""

import numpy as np
import pytest
from sensed import axes, moved, scenario

import hfc_design.api as hfc


def test_difference_and_observer_without_memory_are_the_same():
    difference = moved(scenario("sensors.velocity='encoder'")).command
    changes = ["sensors.velocity='observer'", "sensors.observer_hz=1e5"]
    np.testing.assert_allclose(moved(scenario(*changes)).command, difference, rtol=1e-9)


def test_the_converter_of_a_design_goes_with_its_plant():
    made_for = scenario("limits.resolution=0.5", "limits.delay_samples=1", "limits.command=8.0")
    design = hfc.with_gains(made_for, "pd", {"kp": 758.405, "kd": 743.010})
    other = scenario("reference.velocity=0.03")
    motion = hfc.evaluate(design, other).axes[0].motion
    command = motion.command
    assert motion.state.current[1] == 0.0  # the first acts a sample later
    assert (command % 0.5 == 0.0).all()
    assert abs(command).max() == 8.0
    # A scenario that names its own converter, an ideal one too, has that.
    ideal = scenario("reference.velocity=0.03", "limits.resolution=0", "limits.delay_samples=0")
    motion = hfc.evaluate(design, ideal).axes[0].motion
    command = motion.command
    assert command[0] == 8.0
    assert motion.state.current[1] > 0.0
    assert (command % 0.5 != 0.0).any()
    judged = hfc.evaluate_many([design, "pd-only"], [other, ideal])
    for k, one in enumerate((design, "pd-only")):
        for j, where in enumerate((other, ideal)):
            alone = hfc.evaluate(one, where).fitness
            assert judged.fitness[k, j, 0] == pytest.approx(alone, rel=1e-12)


def test_an_axis_may_be_held_back_alone():
    (x, y), (same, prompt) = axes({"delay_samples": 1}), axes({})
    first = [np.flatnonzero(one.state.velocity)[0] for one in (x, y, same, prompt)]
    assert first[1] == first[3] + 1
    assert first[0] == first[2]
