"""Input shapers: residual vibrations by the formula of Singer and Seering and by simulation."""

import numpy as np
import pytest
from scipy.signal import lsim
from wording import refused

from hfc_design.files.named_scenario import load_scenario
from hfc_design.motion.shapers import SHAPERS, impulses


def residual(shaper, hz, damping):
    """Vibration after the last impulse, relative to that of a single impulse at first (eq. 9)."""
    sizes, times = shaper
    turns = 2.0 * np.pi * hz * times
    vibration = sizes * np.exp(damping * turns + 1j * np.sqrt(1.0 - damping**2) * turns)
    return np.exp(-damping * turns[-1]) * abs(vibration.sum())


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.1])
@pytest.mark.parametrize(
    ("kind", "at_most", "low", "high"),
    [
        ("zv", 1e-12, 1.0, 1.0),
        ("mzv", 1e-12, 1.0, 1.0),
        ("zvd", 1e-12, 1.0, 1.0),
        ("ei", 0.0501, 0.81, 1.19),
        ("2hump_ei", 0.0501, 0.64, 1.36),
        ("3hump_ei", 0.0501, 0.52, 1.48),
    ],
)
def test_what_vibrates_on_is_as_published(kind, at_most, low, high, damping):
    """Nothing at the frequency itself; of EI up to 5 % in the published widths."""
    shaper = impulses(kind, 25.0, damping)
    assert shaper[0].sum() == pytest.approx(1.0)
    assert (shaper[0] > 0.0).all()
    ratios = np.linspace(low, high, 41)
    assert max(residual(shaper, 25.0 * x, damping) for x in ratios) <= at_most
    if kind == "ei" and not damping:  # with equal signs at the middle and no slack
        assert residual(shaper, 25.0, 0.0) == pytest.approx(0.05)


def test_zv_by_hand():
    """Of 10 Hz and 20 % damping: K = exp(-0.2 pi / 0.98), 51 ms apart."""
    sizes, times = impulses("zv", 10.0, 0.2)
    k = np.exp(-0.2 * np.pi / np.sqrt(0.96))
    assert sizes == pytest.approx([1.0 / (1.0 + k), k / (1.0 + k)])
    assert times == pytest.approx([0.0, 0.05 / np.sqrt(0.96)])
    assert {*SHAPERS} == {"none", "zv", "mzv", "zvd", "ei", "2hump_ei", "3hump_ei"}


def test_a_shaped_move_leaves_an_oscillator_at_rest():
    """12.5 Hz without damping, between samples of 1 ms as SciPy has it: 1000 times less remains."""
    move = {"kind": "trapezoidal", "distance": 1.0, "velocity": 9.0, "acceleration": 900.0}
    changes = {"reference": move, "simulation.duration_s": 1.0, "simulation.substeps": 1000}
    shaper = {"kind": "zv", "hz": 12.5, "damping": 0.0}
    swinging = np.array([[0.0, 1.0], [-((25.0 * np.pi) ** 2), 0.0]])
    oscillator = (swinging, [[0.0], [(25.0 * np.pi) ** 2]], [[1.0, 0.0]], 0.0)
    remains = []
    for more in ({}, {"shaper": shaper}):
        told = load_scenario("c-axis-ramp", changes | more)
        (axis,), time = told.samples().axes, told.simulation.time
        assert (axis.target == axis.reference).all()
        assert np.gradient(axis.reference, time) == pytest.approx(axis.reference_rate, abs=0.5)
        remains.append(np.ptp(lsim(oscillator, axis.reference, time)[1][500:]))
    assert remains[0] > 0.4
    assert remains[1] < 1e-3 * remains[0]


def test_a_circle_is_late_and_smaller_and_its_path_is_not():
    """Of 5 mm at 2 rad/s, in steps of 10 um: axes that are 0.1 s late reach 5 mm times cos 0.2."""
    shaper = {"kind": "zv", "hz": 2.5, "damping": 0.0}
    circle = {"kind": "circle", "radius_mm": 5.0, "feed_mm_min": 600.0}
    told = load_scenario("feed-drive-circle", {"reference": circle, "shaper": shaper})
    samples, unit = told.samples(), told.plant.each()[0].length
    k = np.arange(50, 300)
    x, y = (unit * axis.reference[k] for axis in samples.axes)
    np.testing.assert_allclose(np.hypot(x + 5.0, y), 5.0 * np.cos(0.2), atol=0.0071)
    angle = 2.0 * (told.simulation.time[k] - 0.1)
    there = [unit * axis.target[k] for axis in samples.axes]
    np.testing.assert_allclose(there, [5.0 * np.cos(angle) - 5.0, 5.0 * np.sin(angle)], atol=1e-3)
    np.testing.assert_allclose(samples.path.tangent[0][k], -np.sin(angle), atol=1e-3)


@pytest.mark.parametrize(
    ("shaper", "key"),
    [
        ({"kind": "zv"}, "shaper.hz"),
        ({"kind": "ei", "hz": 500.0}, "shaper.hz"),
        ({"kind": "mzv", "hz": 0.3}, "shaper.hz"),
        ({"kind": "ei", "hz": 20.0, "damping": 0.3}, "shaper.damping"),
        ({"kind": "vz", "hz": 20.0}, "shaper.kind"),
        ({"kind": "zv", "hz": 20.0, "axes": {"y": {"hz": 30.0}}}, "shaper.axes.y"),
    ],
)
def test_a_shaper_that_does_not_fit_is_refused_in_a_line(shaper, key):
    with refused() as found:
        load_scenario("c-axis-ramp", {"shaper": shaper, "simulation.duration_s": 2.0})
    assert found.refusal.startswith(f"c-axis-ramp: {key}")


def test_a_jerk_needs_an_acceleration_and_is_positive():
    for more in ({"jerk_mm_s3": 9.0}, {"acceleration_mm_s2": 9.0, "jerk_mm_s3": 0.0}):
        with refused() as found:
            load_scenario("feed-drive-circle", {f"reference.{key}": x for key, x in more.items()})
        assert "reference.jerk_mm_s3" in found.refusal
