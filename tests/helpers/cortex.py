"""Exported C code on a Cortex-M4: compiled by gcc, stepped in QEMU, beside the Python runtime."""

import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np
from c_program import WARNINGS
from wandering import wandering

from hfc_design.controllers.controller import PathView
from hfc_design.files.design import builtin_designs
from hfc_design.files.pairing import axes_of, load_design
from hfc_design.formats import FORMATS, code
from hfc_design.formats.machine_code import sees_path
from hfc_design.motion.contour import local_error
from hfc_design.runtime import Controller, Machine

BOARD = Path(__file__).parents[1] / "interop" / "cortex"
GCC = ("arm-none-eabi-gcc", f"@{BOARD / 'flags'}")
#: The clock of an instruction is 2 ** 6 ns, so that one is more than a tick of the timer.
SHIFT, TICK_NS = 6, 40
QEMU = "qemu-system-arm -M mps2-an386 -display none -monitor none -serial none -no-reboot"
QEMU += f" -semihosting-config enable=on,target=native -icount shift={SHIFT}"
COUNT = 1000
#: What ``main.c`` reads of a design.
STEP = """#include "{name}.h"
typedef {name}_state state;
typedef {name}_real real;
typedef struct {{ {members} }} sample;
enum {{ COUNT = {count}, COMMANDS = {commands} }};
static void begin(state *own) {{ {name}_init(own); }}
static void step(state *own, const sample *now, real *commands) {{ {call}; }}
"""

#: Every built-in design that C is made of; where the axes differ, each of them.
DESIGNS = {part.name: part for x in builtin_designs() for part in load_design(x).by_axis().values()}


class Run(NamedTuple):
    """What the emulator saw."""

    commands: np.ndarray  # (COUNT, commands)
    stack: int  # by how much it grew in the deepest step [bytes]
    instructions: int  # of the longest step


def case(design):
    """Samples (COUNT, numbers) in single precision, and the commands of the runtime for them.

    Of a machine the signals of each axis, then tangent, curvature and contour error of the path
    where that is seen. Two samples are faulty. The signals are halved until less than a quarter of
    the commands is at the limit.
    """
    axes = () if design.kind.law else axes_of(design)
    signals = np.stack([wandering(design, k, COUNT) for k in range(len(axes) or 1)], axis=1)
    while True:
        errors = signals[:, :, list(code.signals(design)).index("error")]
        samples = np.concatenate([signals.reshape(COUNT, -1), _path(design, errors)], axis=1)
        samples = samples.astype(np.float32)
        samples[500, 0], samples[600, -1] = np.nan, np.inf
        expected = _of_the_runtime(design, axes, samples.astype(float))
        if np.mean(np.abs(expected) == design.limits.command) < 0.25:
            return samples, expected
        signals /= 2.0


def _path(design, errors):
    if design.kind.law or not sees_path(design):
        return np.empty((COUNT, 0))
    angle = np.arange(COUNT) / 30.0
    bent = np.where(np.arange(COUNT) < 700, 0.002, -0.001)
    path = np.stack([np.cos(angle), np.sin(angle), bent], axis=1)
    off = [local_error(*row) for row in np.concatenate([-errors, path], axis=1)]
    return np.column_stack([path, off])


def _of_the_runtime(design, axes, samples):
    names = list(code.signals(design))
    if not axes:
        controller = Controller(design)
        rows = (dict(zip(names, row, strict=True)) for row in samples.tolist())
        return np.array([[controller.step(row)] for row in rows])
    controller, found = Machine(design, axes), []
    for row in samples.tolist():
        own = np.array(row[: len(axes) * len(names)]).reshape(len(axes), -1).tolist()
        told = {x: dict(zip(names, y, strict=True)) for x, y in zip(axes, own, strict=True)}
        rest = row[len(axes) * len(names) :]
        path = PathView(tuple(rest[:2]), rest[2], rest[3]) if rest else None
        found.append(list(controller.step(told, path).values()))
    return np.array(found)


def compiled(design, folder, *flags, lookup=None):
    """Objects of the design's own files in a new ``folder``."""
    if lookup:
        code.write_lookup(design, folder, lookup)
    else:
        FORMATS["c"].write(design, folder)
    sources = sorted(path.name for path in folder.glob(f"{code.c_name(design)}*.c"))
    _run(folder, *GCC, *WARNINGS.split(), *flags, "-c", *sources)
    return [f"{Path(source).stem}.o" for source in sources]


def program(design, folder, objects, samples, *flags):
    """An ELF file for the board, which steps a design through ``samples``."""
    name = code.c_name(design)
    members, call = f"{name}_inputs inputs;", f"*commands = {name}_step(own, &now->inputs)"
    if not design.kind.law:
        path, way = (f"{name}_path path;", "&now->path, ") if sees_path(design) else ("", "")
        members = f"{name}_inputs axes[{name}_AXES]; {path}"
        call = f"{name}_step(own, now->axes, {way}commands)"
    commands = "1" if design.kind.law else f"{name}_AXES"
    own = {"members": members, "call": call, "commands": commands, "count": len(samples)}
    (folder / "step.h").write_text(STEP.format(name=name, **own), encoding="ascii")
    samples.tofile(folder / "samples.bin")
    board = [BOARD / "board.c", BOARD / "main.c", "-T", BOARD / "board.ld", "-I."]
    _run(folder, *GCC, *WARNINGS.split(), *flags, *board, *objects, "-lm", "-o", "program.elf")
    return folder / "program.elf"


def stepped(elf, real):
    """Run a program; real is the type of its commands."""
    command = [*QEMU.split(), "-kernel", elf]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
    stack, ticks = np.frombuffer(done.stdout[-8:], np.uint32).tolist()
    commands = np.frombuffer(done.stdout[:-8], real).reshape(COUNT, -1)
    return Run(commands, stack, round(ticks * TICK_NS / 2**SHIFT))


def symbols(path, *flags):
    """Size [bytes] of every symbol of an object or a program that has one, else 0; by name."""
    listing = subprocess.check_output(["arm-none-eabi-nm", "-S", *flags, path], text=True)
    rows = [line.split() for line in listing.splitlines()]
    return {row[-1]: int(row[1], 16) if len(row) == 4 else 0 for row in rows}


def _run(folder, *command):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
