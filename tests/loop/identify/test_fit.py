"""What is found in logs of a cart, by which observer, and what a log says of the drive."""

import os
import re
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from carts import CART, EVERY, Cart, cart_fit, driven, fit_with, forced, noisy, recorded
from moved_masses import FORCE, moved, write
from scipy.optimize import curve_fit
from sledge import MODULE, hfc
from wording import refused

from hfc_design.identify import fit
from hfc_design.identify.fit import by_command, levenberg_marquardt
from hfc_design.identify.identifiability import certainty, unseen_backlash
from hfc_design.identify.identified import saturation_warning
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.replay import replay
from hfc_design.logs.columns import Log, parse_columns
from hfc_design.logs.signals import signals
from plants import PLANTS
from plants.milling_table import MILLING_TABLE
from plants.positioning_stage import POSITIONING_STAGE

WAVE = np.sin(0.05 * np.arange(4000))
TRUE = Cart(mass=2.6, viscous_friction=6.0, force_gain=1.3, pull=-0.4)
NAMES, HELD = ["mass", "viscous_friction"], {"force_gain": 1.3, "pull": -0.4}
STEPS = 800


@pytest.mark.parametrize("bandwidth", [0.0, 5.0])
def test_a_delay_of_two_samples_is_found(bandwidth):
    force = forced(STEPS)
    late = driven(TRUE, np.r_[force[0], force[0], force[:-2]])
    one = cart_fit(NAMES, late, force, HELD, late=True, bandwidth=bandwidth)
    np.testing.assert_allclose(one.values, [2.6, 6.0], rtol=1e-3)
    assert one.late == pytest.approx(2.0, abs=0.01)


def test_mass_and_friction_are_those_of_scipy():
    """And their standard errors, under white noise."""
    force = forced(STEPS)
    place = noisy(driven(TRUE, force), 2e-4, 2)

    def model(_, mass, friction, zero):
        return zero + driven(TRUE._replace(mass=mass, viscous_friction=friction), force)

    values, covariance = curve_fit(model, np.arange(STEPS), place, p0=(2.0, 8.0, 0.0))
    fit = cart_fit(NAMES, place, force, HELD)
    np.testing.assert_allclose(fit.free.values(fit.numbers), values[:2], rtol=1e-6)
    known = certainty(fit)
    white = known.error * known.value / np.sqrt(known.inflated[:-2])
    np.testing.assert_allclose(white, np.sqrt(np.diag(covariance))[:2], rtol=0.01)


def test_no_last_bit_of_a_log_decides_which_observer_it_is_replayed_with():
    """Without noise each leaves nothing but rounding, of which one has less by chance."""
    force, rng, found = forced(4000), np.random.default_rng(0), []
    place = driven(Cart(2.4, 7.0, 1.0, 0.6), force)
    wanted = free_parameters(CART, {}, ("mass", "viscous_friction", "pull"))
    for size in (0.0, 1e-15, 1e-12):
        told = recorded(place * (1.0 + size * rng.uniform(-1.0, 1.0, place.shape)), force)
        tried = [50.0, 20.0, 5.0]
        found.append(by_command(wanted, told, 1, tried, 0, near=True))
    assert [one.problem.bandwidth for one in found] == [50.0] * 3
    for one in found:
        np.testing.assert_allclose(one.values, [2.4, 7.0, 0.6], rtol=1e-6)


@pytest.mark.parametrize(
    ("shares", "best"), [((0.6, 0.3), 5.0), ((0.6, 0.5, 0.2), 2.0), ((0.3,), 50.0)]
)
def test_slower_observers_are_tried_where_a_fast_one_leaves_nearly_all(monkeypatch, shares, best):
    """As beside a soft spring. Of a sine what an observer alone leaves is known in closed form."""
    wave, angle = np.sin(0.05 * np.arange(8000)), 0.05 / EVERY
    told, wanted, asked = recorded(wave, wave), free_parameters(CART, {}, ("mass",)), []

    def starts(free, told, residual, hz, *_, near=False):
        asked.append(hz)
        w, s = 2.0 * np.pi * hz, 1j * angle
        alone = abs(s**2 / (s**2 + 1.4 * w * s + w**2)) / np.sqrt(2.0)
        residual = np.full(8000, shares[len(asked) - 1] * alone)
        return fit_with(wanted, residual, np.zeros((8000, 3)), bandwidth=hz)

    monkeypatch.setattr(fit, "by_starts", starts)
    monkeypatch.setattr(fit, "_with_lag", lambda one: one)
    assert (
        by_command(wanted, told, 1, [50.0], 0, print).problem.bandwidth == 50.0
    )  # it was asked for
    del asked[:]
    far = np.full((8000, 1), 1e9)
    monkeypatch.setattr(fit, "residuals", lambda problem, numbers: far)
    found = by_command(wanted, told, 1, [50.0, 49.0], 0, print)
    assert (found.problem.bandwidth, len(asked)) == (best, len(shares))


def test_slopes_too_steep_to_be_squared_end_a_fit(monkeypatch):
    one = cart_fit(("mass",), WAVE, WAVE)
    steep = np.full((len(WAVE), 1, 3), 1e200)
    monkeypatch.setattr(fit, "slopes", lambda problem, numbers: (0.0 * steep[..., 0], steep))
    assert (
        levenberg_marquardt(one.problem, one.numbers, 1e-3, 5)[0].tolist() == one.numbers.tolist()
    )


def test_commands_that_the_drive_does_not_take_are_told():
    """Two of five are beyond the amplifier's 2 V, too many for any model; one at it is not."""
    wanted = free_parameters(POSITIONING_STAGE, {"highest_voltage": 2.0}, ("mass",))
    fit = fit_with(wanted, WAVE, np.zeros((len(WAVE), 3)))
    (line,) = saturation_warning(fit, np.array([-2.5, -2.0, 0.0, 1.0, 7.0]))
    told = (
        "NOT USABLE: the model cannot reproduce its own log: 40 % of the commands are outside -2 to"
    )
    assert line.startswith(f"{told} 2 V, where the drive saturates")
    (few,) = saturation_warning(fit, np.append(np.zeros(19), 7.0))
    assert few.startswith("5 % of the commands are outside -2 to 2 V, where the drive saturates")
    assert not saturation_warning(fit, np.array([-2.0, 0.0, 2.0]))


@pytest.mark.parametrize(("weight", "seen"), [(0.0, True), (600.0, False)])
def test_a_gap_is_seen_only_where_the_axis_goes_from_flank_to_flank(weight, seen):
    """A weight that the motor holds keeps a table on one flank, however sharp the fit is."""
    wanted = free_parameters(MILLING_TABLE, {}, ("backlash", "load"), around=(weight, 0.0, 0.0))
    table = MILLING_TABLE.coefficients(wanted.start)
    wave = 3.0 * np.sin(0.02 * np.arange(1500)) + weight / float(table.force_gain)

    def sample(state, volts):
        return MILLING_TABLE.step(table, state, volts, (weight,) * 3, EVERY), state.position

    with jax.enable_x64(True):
        begun = MILLING_TABLE.initial_state(jnp.zeros(()))
        place = np.asarray(jax.lax.scan(sample, begun, jnp.asarray(wave))[1])
    told, still = recorded(place, wave), np.zeros((len(place), 4))
    replayed = replay(wanted, told, 20.0, 1)
    one = fit_with(wanted, still[:, 0], still, replayed=replayed, bandwidth=20.0)
    known = certainty(one)._replace(state=("yes", "yes"))
    after, line = unseen_backlash(one, known, told, 1)
    assert after.state == ("yes" if seen else "no", "yes")
    assert after.value.tolist() == [0.4 if seen else 0.0, weight]
    assert line.startswith("" if seen else "the backlash is not visible in this log")
    assert bool(line) != seen


def test_a_plant_that_branches_is_refused_in_a_line(own_plugins, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sys.path.insert(0, str(tmp_path))
    (tmp_path / "mine.py").write_text(MODULE)
    write("log.csv", "time_s,place_m,command_N", moved(5.0, 9.0), FORCE)
    found = hfc("identify", "log.csv", "--plant", "mine:BRANCHING")
    assert found.exit_code == 2
    last = found.stderr.splitlines()[-1]
    assert last.startswith("hfc: plant 'sledge' cannot be replayed: in mine.py, line ")
    assert last.endswith("(TracerBoolConversionError)")
    assert "Traceback" not in found.output
    assert set(os.listdir()) <= {"__pycache__", "log.csv", "mine.py"}


STAGE = PLANTS["positioning-stage"]
TIME = np.arange(400) * 1e-3
PLACE = 3.0 * np.sin(20 * TIME)  # [mm]
VOLTS = np.sin(20 * TIME + 1)


def found(columns, *told):
    return signals(Log(columns), STAGE, parse_columns(told, STAGE), None)


def test_all_gaps_are_told_at_once_with_the_options_that_fill_them():
    """A scope's names: what the line says is taken, and 100 % are the amplifier's 10 V."""
    columns = {"TIME [ms]": 1e3 * TIME, "Actual position [mm]": PLACE, "Set position [mm]": PLACE}
    columns["Torque command [%]"] = 10.0 * VOLTS
    with refused(ValueError) as refusal:
        found(columns)
    one = found(columns, *re.findall(r'--column "(.*?)"', str(refusal.error)))
    np.testing.assert_allclose(one.values["command"], VOLTS, atol=1e-12)
    np.testing.assert_allclose(one.values["position"], PLACE, atol=1e-12)
    assert "reference" in one.values
    with refused(ValueError):
        found(columns, "position=actual position", "command=torque command")
