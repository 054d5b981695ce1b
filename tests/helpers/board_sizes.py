"""What exported C takes on microcontrollers: prints the tables of docs/c.md."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
from board_samples import DESIGNS, ON_UNO, case
from boards import CORTEX, UNO, compiled, firmware, stepped, symbols

from hfc_design.formats import code

FLOAT = ("-DHFC_FLOAT",)
POINTS = 257
BUILT = (
    *("pd-only", "jee-koren-2004-pid", "emps-cascade", "jee-koren-2004-flc"),
    *("jee-koren-2004-aflc", "jee-koren-1995-soflc", "huang-soc", "huang-neural"),
    *("lin-gai-2009-fuzzy-sliding-x", "lin-lee-1999-table-1"),
    *("huang-cross-coupled", "lin-gai-2009-fuzzy-sliding-compensated"),
)
SIZES = ("state", "constants", "code", "library", "stack")
#: By the last heading of a table its board, precisions, and designs with points of a lookup table.
TABLES = {
    "instructions": (
        *(CORTEX, ((), FLOAT)),
        [(x, n) for x in BUILT for n in ((0, POINTS) if DESIGNS[x].kind.lookup else (0,))],
    ),
    "cycles": (UNO, (FLOAT,), [(x, 0) for x in BUILT if x in ON_UNO]),
}


def sizes(board, design, *flags, lookup=0):
    """State, constants, code, those of the library and stack [bytes], and the longest step."""
    real = np.float32 if "-DHFC_FLOAT" in flags else np.float64
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "c"
        objects = compiled(board, design, folder, *flags, lookup=lookup)
        own = linked(board, design, folder, *objects, "-r", "-nostdlib")
        whole = linked(board, design, folder, *objects, "-lm")
        elf = firmware(board, design, folder, objects, case(design)[0].astype(real), *flags)
        found, state = stepped(board, elf, real), symbols(board, elf)["controller"]
    library = sum(whole.values()) - sum(own.values())
    return state, own["rodata"], own["text"], library, found.stack, found.longest


def linked(board, design, folder, *rest):
    """Bytes in flash of what ``_init`` and ``_step`` need, by the kind of section."""
    name = code.c_name(design)
    needed = ("-nostartfiles", f"-Wl,-e,{name}_step", f"-Wl,-u,{name}_init", "-o", "linked")
    subprocess.run([*board.gcc, *needed, *rest], cwd=folder, check=True)
    found = dict.fromkeys(("text", "rodata", "data"), 0)
    for line in board.tool("size", "-A", folder / "linked").splitlines():
        words = line.split()
        if words and (kind := words[0].split(".")[1:2]) and kind[0] in found:
            found[kind[0]] += int(words[1])
    return found


def row(unit, name, points):
    """The cells of a table: double / float, or float."""
    board, precisions, _ = TABLES[unit]
    found = (sizes(board, DESIGNS[name], *flags, lookup=points) for flags in precisions)
    return [" / ".join(f"{x:,}" for x in values) for values in zip(*found, strict=True)]


def main():
    for unit, (_, _, rows) in TABLES.items():
        print("\n| built-in design |", " | ".join((*SIZES, unit)), "|")
        print("|---" * (len(SIZES) + 2) + "|")
        for name, points in rows:
            title = f"`{name}`" + (f", `--lookup {points}`" if points else "")
            print("|", " | ".join((title, *row(unit, name, points))), "|", flush=True)


if __name__ == "__main__":
    main()
