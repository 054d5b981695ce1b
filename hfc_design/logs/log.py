"""A recording as its file has it: columns of numbers by the names that stand there."""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import LARGEST_NUMBER, Floats, Mask

#: The largest file [MB]; an hour of four columns at 1 kHz has some 150.
LARGEST_LOG = 512
#: The most numbers that arrays may have in all, and columns that a table may have.
MOST_NUMBERS, MOST_COLUMNS = 30_000_000, 1000
#: The most that a packed file may unpack to [bytes].
MOST_BYTES = 8 * MOST_NUMBERS
#: The fewest samples that something can be learnt from.
FEWEST = 20


class Log(NamedTuple):
    """Columns of one length, all finite."""

    columns: dict[str, Floats]  # (rows,) each, by name
    sample_time: float | None = None  # [s], where the file says it
    breaks: Mask | None = None  # (rows,) samples are missing before this one; None: none are
    format: str = "CSV"
    texts: tuple[str, ...] = ()  # names of columns that hold no numbers, and are left out

    @property
    def rows(self) -> int:
        """How many samples it has."""
        return len(next(iter(self.columns.values())))


def checked(log: Log) -> Log:
    """The same log; ValueError: it is too short, ragged, or has what is no number."""
    if not log.columns:
        raise ValueError("has no column of numbers")
    lengths = {name: len(column) for name, column in log.columns.items()}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise ValueError(f"its columns differ in length: {told[:200]}")
    if log.rows < FEWEST:
        raise ValueError(f"has {log.rows} samples; {FEWEST} are the fewest that tell something")
    for name, column in log.columns.items():
        if (bad := np.flatnonzero(~(np.abs(column) <= LARGEST_NUMBER))).size:
            raise ValueError(
                f"column {name}: {bad.size} of {log.rows} samples are no numbers up to "
                f"{LARGEST_NUMBER:g}, the first is sample {bad[0] + 1}"
            )
    return log
