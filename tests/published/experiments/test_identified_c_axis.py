"""The experiment on intervals: what a log can tell, and how its table counts."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from experiments.identified_c_axis import coverage
from experiments.identified_c_axis.coverage import Row, repeat, rows_of, table
from experiments.identified_c_axis.logs import HERE, told
from hfc_design.files.named_scenario import load_scenario
from plants.c_axis import CAxisParameters, CAxisState, coefficients, derivative

TRUE = CAxisParameters(rotor_flux=0.7, stator_resistance=1.0, rotor_inertia=0.1)
HELD = {"rotor_resistance": 1.0, "rotor_inductance": 0.3, "stator_inductance": 0.33}


def turning(p, steps=2000):
    """(steps, 2) both angles by Euler under a voltage and a load of many frequencies."""
    times = np.arange(float(steps))
    rows = 60.0 * np.sin(2e-3 * times) + 20.0 * np.sin(0.3 * times), np.cos(0.01 * times)

    def step(state, row):
        rates = derivative(coefficients(p), state, *row)
        state = CAxisState(*(x + 2e-4 * dx for x, dx in zip(state, rates, strict=True)))
        return state, jnp.stack([state.rotor_angle, state.spindle_angle])

    with jax.enable_x64(True):
        return np.asarray(jax.lax.scan(step, CAxisState(*6 * [jnp.zeros(())]), rows)[1])


def test_a_motor_with_others_held_turns_alike():
    other = told(TRUE, HELD)
    assert {name: getattr(other, name) for name in HELD} == HELD
    assert abs(other.stator_resistance / TRUE.stator_resistance - 1.0) > 0.01
    expected = turning(TRUE)
    off = np.abs(turning(other) - expected).max()
    assert off < 1e-8 * np.abs(expected).max()
    assert np.abs(turning(TRUE._replace(**HELD)) - expected).max() > 1e4 * off
    with pytest.raises(ValueError, match="no motor with"):
        told(TRUE, {**HELD, "rotor_resistance": 20.0})  # its current would decay too fast


def test_the_table_counts_by_hand():
    """Of three that are told two are inside; z are 2, 0 and 4 of 0.1 each: ln 1.1 is not 0.1."""
    each = [(np.exp(0.2), "yes"), (1.0, "given"), (np.exp(0.4), "yes"), (9.0, "no")]
    rows = [
        Row(k, "mass", state, 1.0, value, value * np.exp(-0.21), value * np.exp(0.21), 0.1)
        for k, (value, state) in enumerate(each)
    ]
    (line,) = table(rows)
    assert line == ["mass", "2 / 1 / 0 / 1 / 0", "2 of 3", "+2.00", "1.63", "10 %"]


def test_a_repeat_finds_the_machine(tmp_path):
    base = load_scenario(str(HERE / "log.toml"))
    rows = repeat(base, TRUE, 5, near=True)
    assert [row.parameter for row in rows if row.state == "held"]
    sure = [row for row in rows if row.state in ("yes", "given")]
    assert len(sure) >= 12
    z = [np.log(row.value / row.true) / row.error for row in sure]
    assert np.abs(z).max() < 4.0
    file = tmp_path / "rows.csv"
    coverage.write(file, rows)
    assert rows_of(file) == rows
