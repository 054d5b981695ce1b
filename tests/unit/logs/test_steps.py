"""What is seen of an encoder in what it reads."""

import numpy as np
import pytest
from shaken import shaken

from hfc_design.logs.sensors import encoder_step, noise_level

TIME = 1e-3 * np.arange(4000)
MOTION = 10.0 * np.sin(3.0 * TIME)
RANDOM = np.random.default_rng(5)


def test_whole_steps_are_seen_whatever_is_between_them():
    assert encoder_step(5e-4 * np.round(MOTION / 5e-4)) == pytest.approx(5e-4, rel=1e-3)
    assert encoder_step(1.0 + 0.125 * np.round(MOTION / 0.125)) == 0.125
    assert encoder_step(MOTION) is None
    assert encoder_step(0.0 * MOTION) is None


@pytest.mark.parametrize(("step", "text"), [(4.88e-4, 1e-4), (2.0045e-4, 1e-5), (7.6e-5, 1e-5)])
def test_steps_that_a_text_has_rounded_again_are_seen(step, text):
    """Also between samples that are thousands of steps apart, with noise and a wrong sample."""
    fast = np.concatenate([40.0 * MOTION, 400.0 + 0.01 * MOTION])
    noisy = fast + RANDOM.normal(0.0, 0.5 * step, fast.shape)
    read = text * np.round(step * np.round(noisy / step) / text)
    read[77] += 0.43 * step
    assert encoder_step(read) == pytest.approx(step, rel=2e-3)
    assert encoder_step(fast) is None
    assert encoder_step(1e-3 * TIME) is None  # a ramp


@pytest.mark.parametrize("step", [None, 1e-4])
@pytest.mark.parametrize("size", [1e-4, 1e-3])
def test_noise_is_what_was_drawn(size, step):
    """Beside a slow error of the model, and spikes at reversals."""
    off = MOTION / 100.0 + RANDOM.normal(0.0, size, TIME.shape)
    off[::500] += 1.0
    if step:
        off = step * np.round(off / step)
    assert noise_level(off, MOTION, step) == pytest.approx(size, rel=0.2)


def test_stamps_that_tremble_are_no_noise():
    """By 2 % of 30 mm/s in a ms, 0.6 um, where the axis is fast."""
    off = np.gradient(MOTION) * RANDOM.normal(0.0, 0.02, TIME.shape)
    assert noise_level(off + RANDOM.normal(0.0, 1e-4, TIME.shape), MOTION, None) < 1.6e-4


def test_the_slowest_samples_of_an_encoder_are_all_that_are_so_slow():
    """Steps of an encoder come in whole numbers, so that many are just as slow."""
    place = 0.1 + 0.001 * np.cumsum(np.arange(4000) % 7 < 3)
    off = RANDOM.normal(0.0, 1e-4, TIME.shape)
    found = {noise_level(off, np.array(x), None) for x in shaken(*place, times=3, size=1e-15)}
    assert len(found) == 1
