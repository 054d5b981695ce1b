"""The positioning stage in its recorded loop, by hand."""

import pytest

import hfc_design.api as hfc


def test_the_recorded_loop_follows_as_far_behind_as_by_hand():
    """u = k_v (k_p e - v) holds a speed where u g = F_c + offset + F_v v."""
    motion = hfc.evaluate("emps-cascade", "positioning-stage-move").axes[0].motion
    assert motion.state.velocity[1500] == pytest.approx(125.0, rel=2e-4)
    voltage = (20.39 - 3.16 + 203.5 * 0.125) / 35.1507
    assert motion.command[1500] == pytest.approx(
        voltage, abs=0.06
    )  # a step of the encoder: 0.039 V
    wanted = (voltage / 243.45 + 0.125) / 160.18  # [m]
    assert motion.error[1000:2000].mean() == pytest.approx(1e3 * wanted, abs=2e-4)
    assert motion.error[-1] == pytest.approx(0.0, abs=0.02)  # friction holds it against the loop
    assert motion.state.velocity[-1] == 0.0
