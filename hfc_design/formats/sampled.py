"""Signals sampled by a control, as CSV, as a header of C, and as rows for LinuxCNC's streamer.

Columns are given by their names, each with its values (steps,) and their unit.
"""

from collections.abc import Mapping

import numpy as np

from hfc_design.core.numbers import Floats

Columns = Mapping[str, tuple[Floats, str]]
#: Numbers in a line of C.
LINE = 8


def csv(time: Floats, columns: Columns) -> str:
    """Return the columns and the ``time`` [s], with units in the head."""
    head = ["time [s]", *(f"{name} [{unit}]" for name, (_, unit) in columns.items())]
    data = np.stack([time, *(values for values, _ in columns.values())], axis=1)
    return "\n".join([",".join(head), *(",".join(f"{x:.9g}" for x in row) for row in data)]) + "\n"


def c_header(name: str, sample_time: float, columns: Columns) -> str:
    """Return arrays of C of single precision, NAME_COLUMN each, and NAME_SAMPLES."""
    count = f"{name.upper()}_SAMPLES"
    lines = [f"/* {name.capitalize()} of hfc-design: a value every {sample_time:g} s. */"]
    lines.append(f"#define {count} {len(next(iter(columns.values()))[0])}")
    for column, (values, unit) in columns.items():
        lines.append(f"static const float {name}_{column}[{count}] = {{ /* [{unit}] */")
        texts = [f"{x:.7e}f," for x in values]
        lines += [f"  {' '.join(texts[k : k + LINE])}" for k in range(0, len(texts), LINE)]
        lines.append("};")
    return "\n".join(lines) + "\n"


def streamed(columns: Columns) -> str:
    """Return a row of numbers for each sample, as ``halstreamer`` reads them."""
    rows = zip(*(values for values, _ in columns.values()), strict=True)
    return "".join(" ".join(f"{x:.9g}" for x in row) + "\n" for row in rows)
