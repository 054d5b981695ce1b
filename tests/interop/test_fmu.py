"""FMUs as FMPy validates, builds and simulates them, against the runtime and the simulator."""

import os
import subprocess

import connections
import made_up
import numpy as np
import pytest
import whole_machines
from places import TESTS
from sliding import EVERY
from wandering import wandering

from hfc_design.files.loop_setup import axes_of, load_design, own_scenario
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import FORMATS, code
from hfc_design.formats.fmu.axes import loop
from hfc_design.runtime import Controller
from hfc_design.simulation.evaluating import evaluate

HERE = TESTS / "interop"
PYTHON = HERE.parents[1] / ".venv-fmpy" / "bin" / "python"
COUNT = 2_000
LEARNT = ("both learn", "compensated", "nested", "slow and learns")
ADAPTING = {"k_c": 1e-2, "largest_move": 0.5, "error_scale": 3.0}
BUILTIN = ("pd-only", "emps-cascade", "lin-lee-1999-table-1", "jee-koren-2004-pid")
BUILTIN += ("jee-koren-2004-flc", "jee-koren-2004-aflc", "jee-koren-1995-soflc")
BUILTIN += ("huang-soc", "huang-neural")
DESIGNS = {name: load_design(name) for name in BUILTIN} | {
    "adapting hierarchy": made_up.hierarchy(14, 5, adaptation=ADAPTING),
    "lqi": made_up.limited(made_up.linear("lqi", 1), 300.0),
    "fuzzy sliding": EVERY["beside a pid within a limit"],
    **{f"machine: {x}": whole_machines.DESIGNS[x] for x in LEARNT},
}
#: FMPy compiles them from their sources too.
COMPILED = ("lin-lee-1999-table-1", "jee-koren-2004-aflc", "machine: nested")


def table_of(design):
    """Inputs (COUNT, inputs) of a controller, and what the runtime makes of them."""
    if design.kind.law:
        samples, controller = wandering(design, 1, COUNT), Controller(design)
        names = list(code.signals(design))
        rows = (dict(zip(names, row, strict=True)) for row in samples.tolist())
        return samples, np.array([[controller.step(row)] for row in rows])
    happens = whole_machines.happenings(design, COUNT)
    table = whole_machines.in_c(design, happens)
    if not (design.kind.path or "nested" in design.name):
        table = table[:, :-4]
    return table, whole_machines.of_the_runtime(design, happens)[1]


def simulated(jobs):
    """Let FMPy simulate (FMU, inputs, sample time, how it gets its binary); outputs of each."""
    if not PYTHON.exists():
        pytest.skip("FMPy is not installed; make interop installs it")
    arguments, places = [], []
    for fmu, table, every, how in jobs:
        given, place = fmu.with_suffix(".in.npy"), fmu.with_suffix(f".out{how}.npy")
        np.save(given, table)
        arguments.append(f"{fmu},{given},{place},{every}{how and ',' + how}")
        places.append(place)
    command = [PYTHON, HERE / "run_fmu.py", *arguments]
    own = os.environ | {"PATH": f"{PYTHON.parent}:{os.environ['PATH']}"}  # its CMake
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=own)
    assert done.returncode == 0, done.stdout + done.stderr
    return [np.load(place) for place in places]


@pytest.mark.parametrize("name", DESIGNS)
def test_a_controller_does_what_the_runtime_does(name, tmp_path):
    """FMI 2.0 and 3.0, by their own binary and by FMPy's build."""
    design = DESIGNS[name]
    FORMATS["fmu"].write(design, tmp_path / "fmu")
    table, expected = table_of(design)
    hows = ("", "built") if name in COMPILED else ("",)
    fmus = sorted((tmp_path / "fmu").iterdir())
    every = design.controller.sample_time_s
    found = simulated([(fmu, table, every, how) for fmu in fmus for how in hows])
    assert len(found) == 2 * len(hows)
    for commands in found:
        assert commands.shape == expected.shape == (COUNT, expected.shape[1])
        np.testing.assert_allclose(commands, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", ["lin-lee-1999-table-1", "jee-koren-2004-aflc"])
def test_a_connected_controller_commands_what_the_simulation_has(name, tmp_path):
    design, rows, (axis,) = connections.simulated(name)
    FORMATS["fmu"].write(design, tmp_path / "fmu")
    table, every = np.array(rows[:COUNT]), design.controller.sample_time_s
    fixed = axis.drive.coefficients(axis.parameters)
    wanted = np.asarray(axis.motion.command)
    fmus = sorted((tmp_path / "fmu").iterdir())
    for commands in simulated([(fmu, table, every, "") for fmu in fmus]):
        each = commands[:, 0].tolist()
        accepted = [float(axis.drive.accepted(fixed, command)) for command in each]
        size = np.abs(wanted).max()
        np.testing.assert_allclose(accepted, wanted[:COUNT], rtol=0, atol=2e-12 * size)


def given(design, motion, path, noise):
    """Inputs of a closed loop, of what happens to the axes in its motion."""
    columns = []
    for name in loop(design).of("input"):
        *head, signal = name.split(".")
        if head == ["path"]:
            columns.append(
                {"curvature": path.curvature}.get(signal, path.tangent["xy".find(signal[-1])])
            )
            continue
        axis = next((x for x in motion.axes if head[:1] == [x.name]), motion.axes[0])
        if "noise" in head:
            columns.append(axis.happens.noise[noise.index(signal)])
        else:
            own = axis.happens._asdict() | {"load": axis.happens.loads[0]}
            columns.append(own[signal])
    return np.stack([np.asarray(column, float) for column in columns], axis=1)


def with_scenario(name, scenario, *changes):
    where = load_scenario(scenario, changes).model_dump(mode="json", exclude_none=True)
    return load_design(name).model_copy(update={"provenance": {"scenario": where}})


SENSED = (
    *("sensors.encoder_resolution=1e-6", "sensors.noise=1e-6", "sensors.velocity=encoder"),
    *("sensors.difference_samples=3", "sensors.readings={current={resolution=0.01,noise=0.02}}"),
    *("limits.command=30", "limits.resolution=0.05", "limits.delay_samples=1"),
    *("simulation.substeps=3", "load.constant=3"),
)
LOOPS = {
    "emps-cascade": load_design("emps-cascade"),
    "observer": with_scenario(
        load_design("lin-lee-1999-table-1", {"limits": {"command": 200.0, "command_rate": 6e4}}),
        "c-axis-practical",
    ),
    "converter": with_scenario("lin-lee-1999-table-1", "c-axis-sine", *SENSED),
    "slow": load_design("pd-only", {"limits": {"command": 30.0, "command_rate": 200.0}}),
    "a slow drive": with_scenario("pd-only", "c-axis-step", "limits.command_rate=2e4"),
    "jee-koren-2004-flc": load_design("jee-koren-2004-flc"),
    "huang-cross-coupled": load_design("huang-cross-coupled"),
    "lin-gai-2009-pid": load_design("lin-gai-2009-pid"),
}
SLIDING = load_design("lin-gai-2009-fuzzy-sliding")
COUPLED = SLIDING.plant.model_copy(update={"name": "five-axis-coupled"})
LOOPS["axes that act on one another"] = with_scenario(
    SLIDING.model_copy(update={"plant": COUPLED}),
    SLIDING.provenance["scenario"],
    "plant.name=five-axis-coupled",
)
#: Where the table's stiff spring and its friction, which grips, make more of rounding.
STIFF = ("huang-cross-coupled",)


@pytest.mark.parametrize("name", LOOPS)
def test_a_closed_loop_moves_as_in_the_simulator(name, tmp_path):
    design = LOOPS[name]
    FORMATS["fmu-loop"].write(design, tmp_path / "fmu")
    scenario = own_scenario(design, design.name)
    motion = evaluate(design, scenario)
    motion = next(iter(motion.motions.values()), motion)
    path = scenario.each_motion()[0].samples().path
    noise = [*motion.axes[0].drive.encoders, *scenario.sensors.readings]
    table = given(design, motion, path, noise)
    every = design.controller.sample_time_s
    fmus = sorted((tmp_path / "fmu").iterdir())
    for found in simulated([(fmu, table, every, "") for fmu in fmus]):
        outputs = dict(zip(loop(design).of("output"), found.T, strict=True))
        for axis, drive in zip(motion.axes, scenario.plant.machine.drives, strict=True):
            head = f"{axis.name}." if len(motion.axes) > 1 else ""
            command = np.asarray(axis.motion.command)
            if scenario.limits.delay_samples:  # that of a machine's model is the one that acts
                command = np.append(0.0, command[:-1])
            # That PID begins with an error: the code takes it to have stood, the simulator not.
            begin = 1 if name == "lin-gai-2009-pid" else 0
            close(outputs[f"{head}command"][begin:], command[begin:], 1e-12)
            state = axis.motion.state._asdict()
            for field in drive.initial_state(0.0)._fields:  # a delay stands around it
                near = 1e-7 if name in STIFF else 1e-12
                close(outputs[f"{head}state.{field}"][:-1], np.asarray(state[field])[1:], near)


def close(found, expected, share):
    """Within a share of the largest value."""
    assert np.ptp(expected) > 0
    np.testing.assert_allclose(found, expected, rtol=0, atol=share * np.abs(expected).max())


def test_plants_are_valid(tmp_path):
    jobs = []
    for name in ("lin-lee-1999-table-1", "huang-pid", "jee-koren-2004-pid", "lin-gai-2009-pid"):
        design = load_design(name)
        FORMATS["fmu-plant"].write(design, tmp_path / name)
        axes = len(axes_of(design))
        jobs += [
            (fmu, np.tile([9.0, 1.0], (50, axes)), design.controller.sample_time_s, "")
            for fmu in sorted((tmp_path / name).iterdir())
        ]
    for first, second in zip(*[iter(simulated(jobs))] * 2, strict=True):
        np.testing.assert_array_equal(first, second)  # FMI 2.0 and 3.0
        assert np.isfinite(first).all()
        assert np.ptp(first, axis=0).max() > 0
