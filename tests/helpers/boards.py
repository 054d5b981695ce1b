"""Exported C on microcontrollers: compiled by gcc, stepped in emulators, beside the runtime."""

import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from board_samples import COUNT
from c_program import WARNINGS
from places import TESTS

from hfc_design.formats import code, laws
from hfc_design.formats.writing import write

HERE = TESTS / "interop" / "boards"


class Board(NamedTuple):
    """What compiles for a board, and what emulates it."""

    name: str  # of its folder, which has the flags of the compiler
    prefix: str  # of the names of gcc and binutils
    linking: tuple[str, ...]
    emulator: str
    told: Callable[[subprocess.CompletedProcess], bytes]  # what the program put out
    per_tick: float  # instructions or cycles in a tick of its clock

    @property
    def gcc(self):
        """The compiler with its flags."""
        folder = HERE / self.name
        return (f"{self.prefix}gcc", f"@{folder / 'flags'}", *WARNINGS.split())

    def tool(self, name, *arguments):
        """What one of binutils prints."""
        return subprocess.check_output([f"{self.prefix}{name}", *arguments], text=True)


def _by_simavr(done):
    """The bytes in hexadecimal digits between : and ;, among what simavr says itself."""
    return bytes.fromhex("".join(re.findall(r":([0-9a-f]+);", done.stderr.decode("ascii"))))


def _by_qemu(done):
    return done.stdout


#: An instruction takes 2 ** 6 ns, a tick of the timer 40 ns.
QEMU = "qemu-system-arm -M mps2-an386 -display none -monitor none -serial none -no-reboot"
QEMU += " -semihosting-config enable=on,target=native -icount shift=6 -kernel"
SCRIPT = "-T", str(HERE / "cortex" / "board.ld")
CORTEX = Board("cortex", "arm-none-eabi-", SCRIPT, QEMU, _by_qemu, 40 / 64)
UNO = Board("uno", "avr-", (), "simavr -m atmega328p", _by_simavr, 64)
#: What ``main.c`` reads of a design.
STEP = """#include "{name}.h"
typedef {name}_state state;
typedef {name}_real real;
typedef struct {{ {members} }} sample;
enum {{ COUNT = {count}, COMMANDS = {commands} }};
static void begin(state *own) {{ {name}_init(own); }}
static void step(state *own, const sample *now, real *commands) {{ {call}; }}
"""


class Run(NamedTuple):
    """What the emulator saw."""

    commands: np.ndarray  # (COUNT, commands)
    stack: int  # by how much it grew in the deepest step [bytes]
    longest: int  # step, in instructions or cycles


def compiled(board, design, folder, *flags, lookup=0):
    """Objects of the design's own files in a new ``folder``; ``lookup`` points in place of exp."""
    files = code.sources(design)
    if lookup:
        files = code.tabulated(design, lookup)[0]
    write(folder, files)
    sources = sorted(name for name in files if name.endswith(".c"))
    _run(folder, *board.gcc, *flags, "-c", *sources)
    return [f"{Path(source).stem}.o" for source in sources]


def firmware(board, design, folder, objects, samples, *flags):
    """An ELF file for the board, which steps a design through ``samples``."""
    name = code.c_name(design)
    members, call = f"{name}_inputs inputs;", f"*commands = {name}_step(own, &now->inputs)"
    if not design.kind.law:
        path, way = (f"{name}_path path;", "&now->path, ") if laws.of_path(design) else ("", "")
        members = f"{name}_inputs axes[{name}_AXES]; {path}"
        call = f"{name}_step(own, now->axes, {way}commands)"
    commands = "1" if design.kind.law else f"{name}_AXES"
    own = {"members": members, "call": call, "commands": commands, "count": len(samples)}
    (folder / "step.h").write_text(STEP.format(name=name, **own), encoding="ascii")
    samples.tofile(folder / "samples.bin")
    sources = HERE / board.name / "board.c", HERE / "main.c", "-I.", f"-I{HERE}"
    rest = *sources, *objects, "-lm", *board.linking, "-o", "program.elf"
    _run(folder, *board.gcc, *flags, *rest)
    return folder / "program.elf"


def stepped(board, elf, real):
    """Run a program; real is the type of its commands."""
    command = [*board.emulator.split(), elf]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr.decode()
    told = board.told(done)
    stack, ticks = np.frombuffer(told[-8:], np.uint32).tolist()
    commands = np.frombuffer(told[:-8], real).reshape(COUNT, -1)
    return Run(commands, stack, round(ticks * board.per_tick))


def symbols(board, path, *flags):
    """Size [bytes] of every symbol of an object or a program that has one, else 0; by name."""
    rows = map(str.split, board.tool("nm", "-S", *flags, path).splitlines())
    return {row[-1]: int(row[1], 16) if len(row) == 4 else 0 for row in rows}


def _run(folder, *command):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
