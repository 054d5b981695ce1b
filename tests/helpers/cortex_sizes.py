"""What exported C takes on a Cortex-M4: prints the table of docs/c.md."""

import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from cortex import DESIGNS, GCC, case, compiled, program, stepped, symbols

from hfc_design.formats import code

POINTS = 257
NAMES = (
    *("pd-only", "jee-koren-2004-pid", "emps-cascade", "jee-koren-2004-flc"),
    *("jee-koren-2004-aflc", "jee-koren-1995-soflc", "huang-soc", "huang-neural"),
    *("lin-gai-2009-fuzzy-sliding-x", "lin-lee-1999-table-1"),
    *("huang-cross-coupled", "lin-gai-2009-fuzzy-sliding-compensated"),
)
HEADINGS = ("built-in design", "state", "constants", "code", "library", "stack", "instructions")


class Sizes(NamedTuple):
    """Of what ``_init`` and ``_step`` need [bytes], and the instructions of the longest step."""

    state: int
    constants: int
    code: int
    library: int  # code and constants of others
    stack: int
    instructions: int


def sizes(design, *flags, lookup=None):
    """Those of a design, compiled with ``flags``."""
    real = np.float32 if "-DHFC_FLOAT" in flags else np.float64
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "c"
        objects = compiled(design, folder, *flags, lookup=lookup)
        own = linked(design, folder, *objects, "-r")
        whole = linked(design, folder, *objects, "-lm")
        elf = program(design, folder, objects, case(design)[0].astype(real), *flags)
        found, state = stepped(elf, real), symbols(elf)["controller"]
    library = sum(whole.values()) - sum(own.values())
    return Sizes(state, own["rodata"], own["text"], library, found.stack, found.instructions)


def linked(design, folder, *rest):
    """Bytes in flash of what ``_init`` and ``_step`` need, by the kind of section."""
    name = code.c_name(design)
    needed = (f"-Wl,-e,{name}_step", f"-Wl,-u,{name}_init", "-o", "linked")
    subprocess.run([*GCC, *needed, *rest], cwd=folder, check=True)
    command = ["arm-none-eabi-size", "-A", folder / "linked"]
    rows = map(str.split, subprocess.check_output(command, text=True).splitlines())
    found = dict.fromkeys(("text", "rodata", "data"), 0)
    for row in rows:
        if row and (kind := row[0].split(".")[1:2]) and kind[0] in found:
            found[kind[0]] += int(row[1])
    return found


def row(name, lookup=None):
    """One of the table: double / float."""
    both = zip(
        *(sizes(DESIGNS[name], *flags, lookup=lookup) for flags in ((), ("-DHFC_FLOAT",))),
        strict=True,
    )
    title = f"`{name}`" + (f", `--lookup {lookup}`" if lookup else "")
    return [title, *(f"{double:,} / {single:,}" for double, single in both)]


def table():
    """The rows of the table, as Markdown."""
    yield HEADINGS
    yield ["---"] * len(HEADINGS)
    for name in NAMES:
        yield row(name)
        if DESIGNS[name].kind.lookup:
            yield row(name, POINTS)


if __name__ == "__main__":
    for one in table():
        print("|", " | ".join(one), "|", flush=True)
