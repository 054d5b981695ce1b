"""The numpy runtime: by hand, and against the compiled loop."""

import json
import subprocess
import sys

import numpy as np
import pytest
from lifted import controller_of

from hfc_design.controllers.hierarchical.law import LIN_LEE_TERMS
from hfc_design.files.design import Design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.runtime import Controller
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop

SIX_INPUTS = {
    "error": 50.0,
    "deflection": 80.0,
    "deflection_rate": 20.0,
    "spindle_velocity": 20.0,
    "previous_spindle_velocity": 10.0,
    "previous_error": 40.0,
}


def design_of(kp, kd, names, units):
    """A design over ``names``; ``units`` are (column input, row input, table)."""
    return Design.model_validate(
        {
            "name": "made-up",
            "plant": {"name": "c-axis", "parameters": {}},
            "controller": {
                "kind": "pd+hierarchical-fuzzy",
                "sample_time_s": 0.001,
                "pd": {"kp": kp, "kd": kd},
                "inputs": [{"name": name, "scale": SIX_INPUTS[name]} for name in names],
                "output_scale": 10.0,
                "terms": [term._asdict() for term in LIN_LEE_TERMS],
                "units": [
                    {"id": k, "column_input": column, "row_input": row, "consequents": table}
                    for k, (column, row, table) in enumerate(units)
                ],
            },
        }
    )


def random_design(inputs, seed, random_population):
    """A design of the last ``inputs`` inputs with a random tree and random tables."""
    gains = random_population(1, seed, inputs)
    names = list(SIX_INPUTS)[-inputs:]
    labels = names + [f"unit-{k}" for k in range(inputs - 1)]
    tables = gains.consequents[..., 0].tolist()
    pairs = gains.sources[..., 0].tolist()
    units = [
        (labels[column], labels[row], table)
        for (column, row), table in zip(pairs, tables, strict=True)
    ]
    return design_of(gains.kp[0], gains.kd[0], names, units)


def replayed(design, scenario):
    """Commands of the compiled loop and of the runtime that sees the same signals."""
    controller, gains = controller_of(design)
    scenario = load_scenario(scenario, ["simulation.duration_s=1.0"])
    loop = closed_loop(scenario, controller)
    machines = simulate.one_machine(scenario.plant.values())
    _, (motion,) = simulate.trajectory(loop, machines, scenario.samples(), gains)
    state = motion.state
    signals = {
        "error": motion.error,
        "error_rate": motion.error_rate,
        "deflection": state.rotor_angle - state.spindle_angle,
        "deflection_rate": state.rotor_velocity - state.spindle_velocity,
        "spindle_velocity": state.spindle_velocity,
    }
    rows = np.stack(list(signals.values()))[..., 0].T.tolist()
    runtime = Controller(design)
    found = [runtime.step(dict(zip(signals, row, strict=True))) for row in rows]
    return motion.command[:, 0], np.array(found), runtime, dict(zip(signals, rows[0], strict=True))


@pytest.mark.parametrize("scenario", ["c-axis-ramp", "c-axis-ramp-cutting"])
@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "lin-lee-1999-table-2", "pd-only"])
def test_equals_the_loop_on_built_in_designs(name, scenario):
    compiled, found, *_ = replayed(load_design(name), scenario)
    np.testing.assert_allclose(found, compiled, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    "inputs",
    [2, pytest.param(3, marks=pytest.mark.slow), 4, pytest.param(5, marks=pytest.mark.slow), 6],
)
def test_equals_the_loop_on_random_designs(inputs, random_population):
    for seed in range(3):
        design = random_design(inputs, seed, random_population)
        compiled, found, *_ = replayed(design, "c-axis-ramp-cutting")
        np.testing.assert_allclose(found, compiled, rtol=1e-12, atol=1e-12)


def test_reset_forgets_the_past(random_population):
    design = random_design(5, 1, random_population)
    *_, runtime, first = replayed(design, "c-axis-ramp")
    first |= {"spindle_velocity": 0.05}
    remembering = runtime.step(first)
    assert runtime.step(first) != remembering  # the previous velocity is another
    runtime.reset()
    fresh = runtime.step(first)
    assert fresh == Controller(design).step(first)
    assert fresh != remembering


def test_runtime_never_imports_jax():
    code = "import sys, hfc_design.runtime; print([m for m in sys.modules if m[:3] == 'jax'])"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.strip() == "[]"


KIND = """
from typing import NamedTuple

from hfc_design.controllers.gains import Law


class Gains(NamedTuple):
    kp: object


LAW = Law(
    "only-kp",
    Gains((0.1, 10.0)),
    lambda zero: (),
    lambda every, gains, memory, signals: (gains.kp * signals["error"], memory),
)
"""


def test_an_own_kind_is_made_known_without_jax(tmp_path):
    """What the runtime advises where a kind is unknown works, in a script of its own."""
    (tmp_path / "mykind.py").write_text(KIND)
    data = {"name": "own", "plant": {"name": "sledge", "parameters": {}}}
    data["controller"] = {"kind": "only-kp", "sample_time_s": 0.001, "gains": {"kp": 3.0}}
    (tmp_path / "own.json").write_text(json.dumps(data))
    script = """
import sys
from hfc_design import runtime
from hfc_design.core.records import UserError
try:
    runtime.load("own.json")
except UserError as error:
    assert "or runtime.use('module:OBJECT')" in str(error), error
runtime.use("mykind:LAW")
print(runtime.load("own.json").step({"error": 2.0}), "jax" in sys.modules)
"""
    script = [sys.executable, "-c", script]
    done = subprocess.run(script, check=True, capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout == "6.0 False\n"
