"""The C of every plant against the simulator's step, on states and loads all over."""

import ctypes

import jax
import numpy as np
import pytest

from hfc_design.files.loop_setup import load_design
from hfc_design.formats import compiling, plant_code
from plants import PLANTS, machine_of

DESIGN = load_design("pd-only")
DRIVES = {drive.name: drive for plant in PLANTS.values() for drive in machine_of(plant).drives}
#: Largest of each number of a state, and time of a step [s].
REACH = {
    "c-axis": ((20.0, 0.3, 3.0, 0.3, 3.0, 1e-4), 1e-3),
    "feed-drive": ((900.0, 900.0), 0.01),
    "milling-table": ((0.3, 9.0, 0.3, 9.0), 0.005),
    "positioning-stage": ((200.0, 150.0), 1e-3),
}
COUNT = 400


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The C of every drive, whose functions can be called from outside."""
    opened = "#pragma GCC visibility push(default)\n"
    files = {}
    for drive in DRIVES.values():
        own = plant_code.sources(drive, DESIGN)
        files |= {file: opened * file.endswith(".h") + text for file, text in own.items()}
    path = tmp_path_factory.mktemp("c") / "plants.so"
    path.write_bytes(compiling.shared_library(files, "plants"))
    return ctypes.CDLL(str(path))


def numbers(values):
    return (ctypes.c_double * len(values))(*map(float, values))


def happenings(drive):
    """States, commands and three loads of a step; some states at rest."""
    random = np.random.default_rng(4)
    reach, every = REACH.get(drive.name, ((50.0, 100.0), 0.005))
    states = random.uniform(-1.0, 1.0, (COUNT, len(reach))) * reach
    states[::7] *= drive.name == "c-axis"  # at rest; the bristles of the C-axis hold what is bent
    low, high = drive.largest_commands(drive.parameters(), 100.0)
    commands = random.uniform(low, high, COUNT) * random.uniform(0.0, 1.2, COUNT) ** 3
    loads = random.uniform(-2.0, 2.0, (COUNT, 3))
    return states, commands, loads, every


@pytest.mark.parametrize("name", DRIVES)
def test_a_step_is_the_simulators(name, library):
    drive, own = DRIVES[name], plant_code.name_of(DRIVES[name])
    states, commands, loads, every = happenings(drive)
    parameters = drive.parameters()
    fixed = drive.coefficients(parameters)
    coefficients = numbers([0.0] * len(plant_code.coefficients(fixed)))
    getattr(library, f"{own}_prepare")(numbers(parameters), coefficients)
    expected = list(plant_code.coefficients(fixed).values())
    np.testing.assert_allclose(list(coefficients), expected, rtol=4e-16)

    record = type(drive.initial_state(0.0))

    def stepped(state, command, load):
        return drive.step(fixed, state, drive.accepted(fixed, command), tuple(load), every)

    with jax.enable_x64(True):
        fields = record(*states.T)
        expected = jax.jit(jax.vmap(stepped))(fields, commands, loads)
        expected = np.stack(expected, axis=1)
    accepted, step = (getattr(library, f"{own}_{part}") for part in ("accepted", "step"))
    accepted.restype = ctypes.c_double
    found = []
    for state, command, load in zip(states, commands, loads, strict=True):
        after = numbers(state)
        taken = ctypes.c_double(accepted(coefficients, ctypes.c_double(command)))
        step(coefficients, after, taken, numbers(load), ctypes.c_double(every))
        found.append(list(after))
    scale = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=2e-13)
    moved = np.abs(expected - states).max(axis=0)
    assert (moved > 0).all()
    assert (np.array(found)[:, 1] == 0.0).sum() > (0 if name != "c-axis" else -1)  # some rest


@pytest.mark.parametrize("name", ["feed-drive", "milling-table", "positioning-stage", "servo-a"])
def test_what_is_measured_is_the_simulators(name, library):
    drive, own = DRIVES[name], plant_code.name_of(DRIVES[name])
    states, *_ = happenings(drive)
    parameters = drive.parameters()
    coarse = {key: 0.125 for key in ("encoder_resolution",) if key in parameters._fields}
    parameters = parameters._replace(**coarse)
    fixed = drive.coefficients(parameters)
    coefficients = numbers(plant_code.coefficients(fixed).values())
    expected = drive.measured(fixed, type(drive.initial_state(0.0))(*states.T))

    class State(ctypes.Structure):
        _fields_ = [(name, ctypes.c_double) for name in expected._fields]

    measured = getattr(library, f"{own}_measured")
    measured.restype = State
    found = [measured(coefficients, numbers(state)) for state in states]
    for field in expected._fields:
        got = [getattr(one, field) for one in found]
        np.testing.assert_allclose(got, getattr(expected, field), rtol=1e-6)  # of a float32
    assert not np.allclose(expected[0], states[:, 0], rtol=1e-9, atol=0)
