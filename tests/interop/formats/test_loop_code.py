"""A closed loop in WebAssembly: what the simulator computes, and what its judge measures."""

import numpy as np
import pytest
from wasm_node import in_node

from hfc_design import api
from hfc_design.files.loop_setup import own_scenario
from hfc_design.formats.loop_code import LANES, loop_code, rows

#: One of every plant and of most kinds; those that adapt or learn among them.
DESIGNS = (
    *("pd-only", "lin-lee-1999-table-1", "emps-cascade", "huang-pid", "huang-neural"),
    *("jee-koren-1995-fit-soflc", "jee-koren-2004-aflc", "lin-gai-2009-fuzzy-sliding"),
)


def arranged(code, every_row):
    """The memory, the calls that simulate two equal machines, and the places of its arrays."""
    memory, places = [], {}

    def put(name, values, lanes):
        places[name] = 8 * len(memory)
        values = np.repeat(values, 2) if lanes else np.append(values, np.zeros(len(values) % 2))
        memory.extend(values)

    given = {name: getattr(code, name) for name in ("loop", "parameters", "gains", "start")}
    given |= {name: np.zeros(size) for name, size in code.sizes.items()}
    given |= {"nominal": code.parameters, "every": [code.every], "rows": every_row.ravel()}
    for name, values in given.items():
        put(name, values, name in LANES)

    def call(name, arguments):
        return [name, *(places[x] for x in arguments.split())]

    calls = [call("prepare", "loop parameters fixed")]
    calls.append(call("begin", "loop fixed gains start state"))
    sample = call("sample", "loop nominal fixed every gains state")
    width = 8 * every_row.shape[1]
    calls += [[*sample, places["rows"] + width * k] for k in range(len(every_row))]
    calls.append(call("judge", "loop state values"))
    return memory, calls, {name: place // 8 for name, place in places.items()}


@pytest.mark.parametrize("name", DESIGNS)
def test_a_motion_and_its_values_are_those_of_the_simulator(program, name, tmp_path):
    """Last position and command; the rank by the scenario's fitness, which every sample changes."""
    design = api.load_design(name)
    scenario = own_scenario(design, design.name)
    code, steps = loop_code(design, scenario), scenario.simulation.steps
    memory, calls, begins = arranged(code, rows(scenario.samples(), steps))
    evaluation = api.evaluate(design, scenario)
    # Positions are those before the last sample, commands those in the one before.
    after = in_node(program("node"), code.module, memory, [*calls[:-2], calls[-1]], tmp_path)
    for k, axis in enumerate(evaluation.axes):
        position = getattr(axis.motion.state, axis.drive.position)
        places = {code.places[k]: position[-1], code.commands + k: axis.motion.command[-2]}
        sizes = np.abs(position).max(), np.abs(axis.motion.command).max()
        for (place, wanted), size in zip(places.items(), sizes, strict=True):
            lanes = after[begins["state"] + 2 * place :][:2]
            np.testing.assert_allclose(lanes, wanted, rtol=0.0, atol=1e-9 * size)
    after = in_node(program("node"), code.module, memory, calls, tmp_path)
    values = after[begins["values"] :].reshape(-1)[: 2 * len(code.metrics)]
    np.testing.assert_allclose(values[:2], evaluation.fitness, rtol=1e-9)
