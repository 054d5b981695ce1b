"""Hierarchies over named inputs of the C-axis, by hand or at random, and their closed loop."""

import numpy as np
from lifted import controller_of
from populations import trajectory

from hfc_design.controllers.hierarchical.law import LIN_LEE_TERMS
from hfc_design.files.design import Design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runtime import Controller, explain
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


SIGNALS = ("error", "error_rate", "deflection", "deflection_rate", "spindle_velocity")


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
    _, (motion,) = trajectory(loop, machines, scenario.samples(), gains)
    state = motion.state
    columns = [motion.error, motion.error_rate, state.rotor_angle - state.spindle_angle]
    columns += [state.rotor_velocity - state.spindle_velocity, state.spindle_velocity]
    rows = np.stack(columns)[..., 0].T.tolist()
    runtime = Controller(design)
    found = [runtime.step(dict(zip(SIGNALS, row, strict=True))) for row in rows]
    return motion.command[:, 0], np.array(found)


def explanation(design, texts):
    """Of a design for the machine that its file names."""
    plant = PlantSettings(**design.plant.model_dump())
    return explain.explanation(design, plant.machine.drives[0], plant.values()[0], texts)
