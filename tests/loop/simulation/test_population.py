"""The population simulator: published scores, independence of individuals, sensors, Jacobian."""

import jax
import numpy as np
import pytest
from lifted import every_axis
from populations import LAW, fitness, picked, prepared, trajectory

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.pd import PdGains, initial_memory, sample
from hfc_design.simulation.flattening import packed, unpacked

PD = every_axis("pd", AxisLaw(sample, initial_memory, 0.001))


def test_one_compilation_serves_all_structures_values_machines_and_loads(random_population):
    """Whoever diverges is alone in it."""
    gains = random_population(65, seed=4)
    traces = []

    def sample(*arguments):
        traces.append(1)
        return LAW.sample(*arguments)

    counted = every_axis("pd+hierarchical-fuzzy", LAW._replace(sample=sample))

    def changed(change, shift):
        loop = prepared(counted, change)
        return fitness(*loop, picked(gains, np.roll(np.arange(65), shift)))

    first = changed("load.constant=5.0", 0)
    needed = len(traces)
    assert needed > 0
    others = [
        changed("load.constant=5.0", 1),
        changed("load.constant=1.0", 0),
        changed("reference.velocity=0.03", 0),
        changed("plant.parameters.spindle_inertia=4.0", 0),
    ]
    assert len(traces) == needed
    assert all((other != first).any() for other in others)
    kd = gains.kd.copy()
    kd[[3, 20]] = 1e9
    found = fitness(*prepared(counted, "load.constant=5.0"), gains._replace(kd=kd))
    assert len(traces) == needed
    assert np.flatnonzero(np.isnan(found)).tolist() == [3, 20]
    others = ~np.isnan(found)
    assert (found[others] == first[others]).all()


def test_encoder_reads_multiples_of_its_resolution():
    """A P controller of gain 1 shows the error that the encoder leaves, a D controller the rate."""
    changes = ["sensors.encoder_resolution=1e-4", "sensors.velocity='encoder'"]
    gains = PdGains(np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    push = ["reference.velocity=0.0", "load={constant=2.0}"]
    _, (motion,) = trajectory(*prepared(PD, *changes, *push), gains)
    angle = motion.state.spindle_angle
    read = -motion.command[:, 0]
    assert abs(angle[:, 0]).max() > 1e-3
    np.testing.assert_allclose(read / 1e-4, np.round(read / 1e-4), atol=1e-9)
    assert abs(read - angle[:, 0]).max() <= 0.5e-4 * (1 + 1e-9)
    # The encoder's velocity is the difference of two readings, the first from rest at zero.
    wanted = np.diff(np.round(angle[:, 1] / 1e-4) * 1e-4, prepend=0.0) / 0.001
    np.testing.assert_allclose(-motion.command[:, 1], wanted, atol=1e-9)
    # The score and the recorded error are those of the machine, not of what its sensors see.
    np.testing.assert_allclose(motion.error, -angle)


def test_noise_is_that_of_its_seed():
    gains = PdGains(np.array([1.0]), np.array([0.0]))

    def disturbance(*changes):
        changes = ("sensors.noise=1e-5", "reference.velocity=0.0", *changes)
        _, (motion,) = trajectory(*prepared(PD, *changes, scenario="c-axis-ramp"), gains)
        return (-motion.command - motion.state.spindle_angle)[:, 0]

    first = disturbance()
    assert (disturbance() == first).all()
    assert (disturbance("sensors.seed=1") != first).all()
    assert first.std() == pytest.approx(1e-5, rel=0.2)  # 200 samples: 5 % is one sigma
    assert abs(first.mean()) < 3e-6


TREE = {
    "table": np.arange(24.0).reshape(2, 3, 4),
    "sources": np.array([[5, 6, 7, 8]], np.int64),
    "none": None,
    "gain": np.array([1.5, 2.5, 3.5, 4.5]),
}


def test_chunks_of_what_was_packed():
    form, numbers = packed(TREE, np.float32, 2)
    assert numbers.floats.shape == (2, 7, 2)
    assert numbers.floats.dtype == np.float32
    assert numbers.integers.tolist() == [[[5, 6]], [[7, 8]]]
    for k in range(2):
        own = jax.tree.map(lambda leaf, k=k: leaf[k], numbers)
        found = jax.jit(unpacked, static_argnums=0)(form, own)
        wanted = jax.tree.map(lambda leaf, k=k: leaf[..., 2 * k : 2 * k + 2], TREE)
        jax.tree.map(np.testing.assert_array_equal, found, wanted)


def test_single_numbers_without_integers():
    form, numbers = packed((2.0, (), np.arange(3.0)), np.float64)
    assert numbers.floats.tolist() == [2.0, 0.0, 1.0, 2.0]
    assert numbers.integers.shape == (0,)
    number, empty, several = unpacked(form, numbers)
    assert (number, empty, several.tolist()) == (2.0, (), [0.0, 1.0, 2.0])
