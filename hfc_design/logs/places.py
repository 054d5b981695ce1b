"""Positions and references of several axes in a log."""

from collections.abc import Iterable, Mapping
from contextlib import suppress

from hfc_design.core.numbers import Floats
from hfc_design.core.quantities import number
from hfc_design.logs.columns import MAPPED, Log, column_hint, listed_columns, parts_of

#: End of the name of a column that need not be there.
IMPLIED = "_position"


def places(
    log: Log, assigned: Iterable[str], units: Mapping[str, str], needed: Iterable[str]
) -> dict[str, Floats]:
    """Return signals of a log (rows,), by their names or as ``assigned``, as in "x=qm [um]".

    Args:
        log: the columns of the log.
        assigned: columns of signals that are not found by their names.
        units: unit of each signal that is wanted.
        needed: signals that the log must have.

    Raises:
        ValueError: an assignment is wrong, or a signal is missing.
    """
    columns = dict[str, tuple[str, str | None]]()
    for name, unit in units.items():
        for column in log.columns:
            if _parts(column, unit)[0].lower().removesuffix(IMPLIED) == name.lower():
                columns[name] = column, None
    for text in assigned:
        match = MAPPED.fullmatch(text)
        name, wanted = (match["name"].lower(), match["column"]) if match else ("", "")
        name = next((known for known in units if known.lower() == name), name)
        unit = units.get(name, "")
        named = [x for x in log.columns if wanted in (x, _parts(x, unit)[0])]
        if not match or not unit or not named:
            known = f"NAME=COLUMN with a name of {', '.join(units)}"
            raise ValueError(f"{text[:60]!r}: must be {known}; {listed_columns(log)}")
        columns[name] = named[0], match["unit"]
    if missing := [name for name in needed if name not in columns]:
        hint = f"{column_hint(missing[0])}; {listed_columns(log)}"
        raise ValueError(f"which column is {missing[0]}? {hint}")
    signals = {}
    for name, (column, given_unit) in columns.items():
        count = given_unit or _parts(column, units[name])[1]
        scale = number(count if count[0] in "+-.0123456789" else f"1 {count}", units[name])
        signals[name] = scale * log.columns[column]
    return signals


def _parts(column: str, unit: str) -> tuple[str, str]:
    """Return the name of a column and the unit at its end; ``unit``: it has none of that kind."""
    for begin, end in parts_of(column):
        with suppress(ValueError):
            number(f"1 {end}", unit)
            return begin, end
    return column, unit
