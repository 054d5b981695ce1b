"""C that adapts as the runtime does, Structured Text with the rules to start from, the exports."""

import numpy as np
import pytest
from c_program import built, commands
from sliding import EVERY

from hfc_design.runtime import Controller

SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")


def wandering(count=3000):
    """Errors and rates all over the table and beyond it, with rests, jumps and whole numbers."""
    random = np.random.default_rng(0)
    k = np.arange(count)
    error = 50.0 * np.sin(k / 40.0) + random.normal(0.0, 3.0, count)
    rate = 1500.0 * np.cos(k / 40.0) + random.normal(0.0, 200.0, count)
    error[1000:1100], rate[1000:1100] = 0.0, 0.0
    error[2000:] = np.round(error[2000:])
    error[::50] *= 3.0
    corners = [[20.0 * i, 2000.0 / 3.0 * j] for i in range(-4, 5) for j in range(-4, 5)]
    far = [[x, y] for x in (1.7e308, -1.7e308, 0.0, 1e-300) for y in (1e300, -1e300, 0.0)]
    return np.array([*np.stack([error, rate], axis=1), *corners, *far, [1.0, 1.0]])


def of_the_runtime(design, samples):
    controller = Controller(design)
    rows = (dict(zip(("error", "error_rate"), row, strict=True)) for row in samples.tolist())
    return np.array([controller.step(row) for row in rows])


@pytest.mark.parametrize("name", EVERY)
def test_c_equals_the_runtime(name, tmp_path):
    found = commands(built("gcc", EVERY[name], tmp_path / "c", *SANITIZERS), wandering())
    expected = of_the_runtime(EVERY[name], wandering())
    if name == "alone":  # a step that overflows makes a faulty sample
        assert np.isnan(expected).any()
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_infinities_and_nan_make_a_faulty_sample_alone(tmp_path):
    samples = wandering(600)
    odd = np.array([[np.nan, 0.0], [0.0, np.inf], [-np.inf, np.nan]])
    program = built("gcc", EVERY["beside a pid within a limit"], tmp_path / "c", *SANITIZERS)
    found = commands(program, np.concatenate([samples[:300], odd, samples[300:]]))
    assert np.isnan(found[300:303]).all()
    rest = np.concatenate([found[:300], found[303:]])
    np.testing.assert_array_equal(rest, commands(program, samples))
