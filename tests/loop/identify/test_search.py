"""Which observer a log is replayed with, and what its commands say of the drive."""

import numpy as np
from carts import CART, Cart, driven, forced, recorded

from hfc_design.identify.fit import Fit, by_command
from hfc_design.identify.free import free
from hfc_design.identify.identified import beyond
from plants.positioning_stage import POSITIONING_STAGE

WAVE = np.sin(0.05 * np.arange(4000))


def test_no_last_bit_of_a_log_decides_which_observer_it_is_replayed_with():
    """Without noise each leaves nothing but rounding, of which one has less by chance."""
    force, rng, found = forced(4000), np.random.default_rng(0), []
    place = driven(Cart(2.4, 7.0, 1.0, 0.6), force)
    wanted = free(CART, {}, ("mass", "viscous_friction", "pull"))
    for size in (0.0, 1e-15, 1e-12):
        told = recorded(place * (1.0 + size * rng.uniform(-1.0, 1.0, place.shape)), force)
        tried = [50.0, 20.0, 5.0]
        found.append(by_command(wanted, told, 1, tried, 0, lambda line: None, near=True))
    assert [one.bandwidth for one in found] == [50.0] * 3
    for one in found:
        np.testing.assert_allclose(wanted.values(one.fit.numbers), [2.4, 7.0, 0.6], rtol=1e-6)


def test_commands_that_the_drive_does_not_take_are_told():
    """Two of five are beyond the amplifier's 2 V; one at the limit is not."""
    wanted = free(POSITIONING_STAGE, {"highest_voltage": 2.0}, ("mass",))
    fit = Fit(wanted, wanted.begun, *[WAVE] * 3, 1)
    (line,) = beyond(fit, np.array([-2.5, -2.0, 0.0, 1.0, 7.0]))
    assert line.startswith("40 % of the commands are beyond the -2 to 2 V that the drive takes")
    assert not beyond(fit, np.array([-2.0, 0.0, 2.0]))
