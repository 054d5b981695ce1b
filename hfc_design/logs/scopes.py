"""Logs of the scopes of controls, whose channels may have sample times of their own.

TwinCAT 3 Scope, "Export in csv": options in Beckhoff's manual TE13xx; layout as in the exports of
version 3.4.3145 with which pytcs (github.com/CagtayFabry/pytcs) is tested. Trace of SINUMERIK
Operate as XML: no description is published; layout as in the trace of version 01.00.03.02 in the
history of github.com/hailongchenn/sinumerik-trace-viewer, where a value that has not changed is
left out (no signal of the drive has the same value twice in a row).
"""

import re
from array import array
from collections import Counter, defaultdict
from io import StringIO
from xml.etree import ElementTree

import numpy as np

from hfc_design.core.numbers import Floats, number_of, number_or_none
from hfc_design.core.records import harmless
from hfc_design.logs.columns import MOST_COLUMNS, MOST_NUMBERS, Log, is_unit, joined
from hfc_design.logs.texts import at_line, with_unit

#: First lines of Scope's export; the group is the separator.
TWINCAT = re.compile(r"Name(\W).*\s+File\1")
#: Settings of a channel of Scope that change its numbers -> their values without effect.
SCALES = {"Offset": 0, "ScaleFactor": 1, "Unit Offset": 0, "Unit ScaleFactor": 1}


def twincat_log(text: str, separator: str) -> Log:
    """Return a log of TwinCAT's Scope; ValueError: it has no times, or a line is wrong."""
    lines = [(k, x) for k, x in enumerate(text.splitlines(), 1) if x.strip() not in ("", "EOF")]
    first = (x.partition(separator)[0].replace(",", ".") for _, x in lines)
    begin = next((k for k, x in enumerate(first) if number_or_none(x) is not None), len(lines))
    head = [[x.strip() for x in line.split(separator)] for _, line in lines[2:begin]]
    keys = {row[0]: row for row in head}
    names, rows = keys.get("Name", [""]), lines[begin:]
    while len(names) > 1 and not names[-1]:
        names.pop()
    if names[0] != "Name" or not rows:
        raise ValueError("must have channels and their times: export it from Scope with timelines")
    if len(names) > MOST_COLUMNS or len(rows) * len(names) > MOST_NUMBERS:
        raise ValueError(f"must have at most {MOST_COLUMNS} columns and {MOST_NUMBERS} numbers")
    table = np.full((len(rows), len(names)), np.nan)
    for row, (place, line) in zip(table, rows, strict=True):
        written = line if separator == "," else line.replace(",", ".")
        numbers = [at_line(place, x) if x.strip() else np.nan for x in written.split(separator)]
        if len(numbers) > len(names) + 1 or (place == rows[0][0] and len(numbers) < len(names)):
            advice = "with timelines, and with tabs or semicolons between columns"
            has = f"has {len(numbers)} columns, the channels {len(names)}"
            raise ValueError(f"line {place}: {has}: export it from Scope {advice}")
        row[: len(numbers)] = numbers[: len(names)]
    return _channels(names, keys, table)


def _channels(names: list[str], keys: dict[str, list[str]], table: Floats) -> Log:
    """Return the log in a table: a column of times, ``Name``, is for the channels after it."""
    groups, scaled = dict[bytes, dict[str, Floats]](), list[str]()
    for k, name in enumerate(names):
        if name in ("Name", ""):
            recorded = np.isfinite(table[:, k])
            times = table[recorded, k]
            full = abs(times[0]) > 1e15  # counted from the year 1601
            started = {"time [100 ns]" if full else "time [ms]": times}
            group = groups.setdefault(times.tobytes(), started)
            continue
        settings = {key: row[k] for key, row in keys.items() if len(row) > k}
        unit = settings.get("Unit", "").partition(" (")[0]  # "mm (Length)", "(None)"
        column = harmless(with_unit(name[:100], unit if is_unit(unit) else ""))
        if column in group:
            raise ValueError(f"columns must have different names (got {column[:60]!r} twice)")
        group[column] = table[recorded, k]
        if any(number_or_none(settings.get(key, "")) not in (None, x) for key, x in SCALES.items()):
            scaled.append(name)
    note = f"{', '.join(scaled)[:80]}: scaled in Scope, if its export did so: check the units"
    notes = (note,) if scaled else ()
    return joined([Log(x, format="TwinCAT", notes=notes) for x in groups.values()])


def sinumerik_log(text: str) -> Log:
    """Return a trace of SINUMERIK, its first data frame; ValueError: the XML is something else."""
    signals, numbers = dict[str, dict[str, str]](), array("d")
    try:
        for _, element in ElementTree.iterparse(StringIO(text)):
            facts = element.attrib
            if element.tag == "dataSignal" and not numbers:
                signals[facts["id"]] = dict(facts)
            elif element.tag == "rec":
                row = (number_of(facts[x]) if x in facts else np.nan for x in ("time", *signals))
                numbers.extend(row)
                element.clear()
            if element.tag == "dataFrame":
                break
            if len(numbers) > MOST_NUMBERS or len(signals) > MOST_COLUMNS:
                raise ValueError(f"more than {MOST_COLUMNS} signals or {MOST_NUMBERS} numbers")
        if not (signals and numbers):
            raise ValueError("no dataFrame with records")
        return joined(_traced(signals, np.array(numbers).reshape(-1, 1 + len(signals))))
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise ValueError(f"is XML, but not a readable trace of SINUMERIK: {error}") from None


def _traced(signals: dict[str, dict[str, str]], table: Floats) -> list[Log]:
    """Return the groups of signals that begin together and have one interval."""
    called = {x: re.sub(r"\s*\(\d+ bit\)", "", row["description"]) for x, row in signals.items()}
    twice = Counter(called.values())
    groups = defaultdict[tuple[float, float], dict[str, Floats]](dict)
    for (x, row), values in zip(signals.items(), table.T[1:], strict=True):
        written = np.isfinite(values)
        times, step = table[written, 0], number_of(row["interval"])
        if step <= 0 or (np.diff(times) <= 0).any():
            raise ValueError(f"the interval must be above 0 and times must rise (got {step:g} s)")
        if not len(times):
            continue
        steps = (table[-1, 0] - times[0]) / step
        if steps * len(signals) > MOST_NUMBERS:
            raise ValueError(f"more than {MOST_NUMBERS} numbers at an interval of {step:g} s")
        middles = times[0] + (np.arange(int(steps + 0.01) + 1) + 0.5) * step
        end = re.sub(r"[][,]", "", row["name"].rpartition("/")[2])
        name = called[x] if twice[called[x]] == 1 else f"{called[x]} {end}"
        if harmless(name[:100]) in (group := groups[step, times[0]]):
            raise ValueError(f"signals must have different names (got {name[:60]!r} twice)")
        group[harmless(name[:100])] = values[written][np.searchsorted(times, middles) - 1]
    return [Log(x, step, format="SINUMERIK") for (step, _), x in groups.items()]
