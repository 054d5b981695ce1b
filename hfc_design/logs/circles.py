"""Positions of X and Y in a log, for a circular test."""

from collections.abc import Iterable
from contextlib import suppress

from hfc_design.core.numbers import Floats
from hfc_design.core.quantities import number
from hfc_design.logs.columns import MAPPED, Log, column_hint, listed_columns, parts_of

#: Signals -> their units; the end of the name of a column that need not be there.
SIGNALS = {"x": "mm", "y": "mm", "x_reference": "mm", "y_reference": "mm", "time": "s"}
IMPLIED = "_position"


def positions(log: Log, assignments: Iterable[str]) -> dict[str, Floats]:
    """Return the ``SIGNALS`` in a log (rows,), by their names or ``assignments``, as "X=qm [um]".

    Raises:
        ValueError: an assignment is wrong, or the log has no X or no Y.
    """
    columns = dict[str, tuple[str, str | None]]()
    for name, unit in SIGNALS.items():
        for column in log.columns:
            if _parts(column, unit)[0].lower().removesuffix(IMPLIED) == name:
                columns[name] = column, None
    for text in assignments:
        match = MAPPED.fullmatch(text)
        name, wanted = (match["name"].lower(), match["column"]) if match else ("", "")
        unit = SIGNALS.get(name, "")
        named = [x for x in log.columns if wanted in (x, _parts(x, unit)[0])]
        if not match or not unit or not named:
            known = f"NAME=COLUMN with a name of {', '.join(SIGNALS)}"
            raise ValueError(f"{text[:60]!r}: must be {known}; {listed_columns(log)}")
        columns[name] = named[0], match["unit"]
    if missing := [name for name in ("x", "y") if name not in columns]:
        hint = f"{column_hint(missing[0])}; {listed_columns(log)}"
        raise ValueError(f"which column is the position {missing[0]}? {hint}")
    values = {}
    for name, (column, told_unit) in columns.items():
        count = told_unit or _parts(column, SIGNALS[name])[1]
        scale = number(count if count[0] in "+-.0123456789" else f"1 {count}", SIGNALS[name])
        values[name] = scale * log.columns[column]
    return values


def _parts(column: str, unit: str) -> tuple[str, str]:
    """Return the name of a column and the unit at its end; ``unit``: it has none of that kind."""
    for begin, end in parts_of(column):
        with suppress(ValueError):
            number(f"1 {end}", unit)
            return begin, end
    return column, unit
