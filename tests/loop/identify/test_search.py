"""Which observer a log is replayed with, and what it says of the drive and of its gap."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from carts import CART, EVERY, Cart, driven, forced, recorded

from hfc_design.identify.certainty import certainty
from hfc_design.identify.fit import Fit, Found, Problem, by_command
from hfc_design.identify.free import free
from hfc_design.identify.identified import beyond, unseen_gap
from hfc_design.identify.replay import replay
from plants.milling_table import MILLING_TABLE
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
    """Two of five are beyond the amplifier's 2 V, which no model stands; one at the limit is not."""
    wanted = free(POSITIONING_STAGE, {"highest_voltage": 2.0}, ("mass",))
    fit = Fit(wanted, wanted.begun, *[WAVE] * 3, 1)
    (line,) = beyond(fit, np.array([-2.5, -2.0, 0.0, 1.0, 7.0]))
    told = "NOT USABLE: the model cannot drive its own log: 40 % of the commands are beyond the -2 to"
    assert line.startswith(f"{told} 2 V that the drive takes")
    (few,) = beyond(fit, np.append(np.zeros(19), 7.0))
    assert few.startswith("5 % of the commands are beyond the -2 to 2 V that the drive takes")
    assert not beyond(fit, np.array([-2.0, 0.0, 2.0]))


@pytest.mark.parametrize(("weight", "seen"), [(0.0, True), (600.0, False)])
def test_a_gap_is_seen_only_where_the_axis_goes_from_flank_to_flank(weight, seen):
    """A weight that the motor holds keeps a table on one flank, however sharp the fit is."""
    wanted = free(MILLING_TABLE, {}, ("backlash", "load"), around=(weight, 0.0, 0.0))
    table = MILLING_TABLE.coefficients(wanted.start)
    wave = 3.0 * np.sin(0.02 * np.arange(1500)) + weight / float(table.force_gain)

    def sample(state, volts):
        return MILLING_TABLE.step(table, state, volts, (weight,) * 3, EVERY), state.position

    with jax.enable_x64(True):
        begun = MILLING_TABLE.initial_state(jnp.zeros(()))
        place = np.asarray(jax.lax.scan(sample, begun, jnp.asarray(wave))[1])
    told, still = recorded(place, wave), np.zeros((len(place), 1))
    fit = Fit(wanted, wanted.begun, still, np.zeros((len(place), 1, 4)), np.ones(1), 1)
    problem = Problem(wanted, replay(wanted, told, 20.0, 1), np.ones(1), np.ones(4))
    known = certainty(fit)._replace(told=(True, True))
    after, states, line = unseen_gap(Found(fit, problem, 20.0), known, ("yes",) * 2, told, 1)
    assert (states, after.told) == (("yes" if seen else "no", "yes"), (seen, True))
    assert line.startswith("" if seen else "the backlash is not seen in this log: ")
    assert bool(line) != seen
    assert np.isnan(after.low).tolist() == [not seen, False]
