"""C that adapts as the runtime does, Structured Text with the rules to start from, the exports."""

import numpy as np
import pytest
from c_program import built, commands
from sliding import EVERY, of_the_runtime, wandering

SANITIZERS = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")


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
