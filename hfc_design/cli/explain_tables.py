"""Tables of ``hfc explain``: signals, degrees, rules and parts of the command in a sample."""

from collections.abc import Iterator

from hfc_design.core.numbers import Json
from hfc_design.core.tables import MISSING, Table, text

#: Part of a command -> its name in the table of the command.
PARTS = {
    "proportional": "kp error",
    "derivative": "kd error_rate",
    "fuzzy": "fuzzy",
    "integral": "integral",
    "compensation": "low-velocity compensation",
}
HELD = (
    "Nothing adapts: the rules that fired in the previous sample are not known. Give the previous "
    "sample in another --at to see the adaptation."
)
NO_RATE = (
    "The rate of the command is not limited: the previous command is not known. Give the previous "
    "sample in another --at."
)
CONVERTED = (
    "From the converter: the command as the drive receives it, rounded to whole steps or limited."
)
#: Largest width for the degrees of all terms in one row [characters].
WIDEST = 42


def tables(explanation: Json, least: float) -> Iterator[Table]:
    """Yield the tables of an ``explain.explanation``; rules below ``least`` are only counted."""
    lines = [f"design {explanation['design']}, kind {explanation['kind']}"]
    if "inside" in explanation:
        lines.append(
            f"These are the wrapped controllers; what {explanation['inside']} adds depends on "
            "the whole machine."
        )
    lines += [HELD] * explanation["adaptation_held"] + [NO_RATE] * explanation["rate_left_out"]
    yield text(*lines)
    yield _signals(explanation)
    for unit in explanation["units"]:
        yield _degrees(unit)
        yield _rules(unit, least)
    if "scheduled" in explanation:
        parts = explanation["scheduled"]
        yield _sum("scheduled law", parts, sum(parts.values()), explanation["command_unit"])
    yield _command(explanation)


def _signals(explanation: Json) -> Table:
    scaled = ("scale", "scaled", "clamped") if "inputs" in explanation else ()
    units = explanation["units_of_signals"]
    inputs = {item["name"]: item for item in explanation.get("inputs", ())}
    readings = {name: item["reading"] for name, item in inputs.items()} | explanation["signals"]
    called = {signal: name for name, signal in explanation.get("names", {}).items()}
    rows = []
    for name, reading in readings.items():
        label = f"{called[name]} ({name})" if name in called else name
        row = [label, f"{reading:.6g}", units.get(name, "")]
        if name in inputs:
            value = inputs[name]["scaled"]
            clamped = f"{min(max(value, -1.0), 1.0):.4f}"
            row += [f"{inputs[name]['scale']:.4g}", f"{value:.4f}", clamped]
        rows.append(row + [""] * (3 + len(scaled) - len(row)))
    return Table("", ("signal", "value", "unit", *scaled), rows, title="signals")


def _degrees(unit: Json) -> Table:
    row, column = sides = unit["row"], unit["column"]
    title, labels = f"fuzzy unit '{unit['unit']}': degrees of the terms", list(row["degrees"])
    rows = []
    if labels == list(column["degrees"]) and sum(max(len(x), 5) + 1 for x in labels) <= WIDEST:
        for side in sides:
            degrees = (
                f"{degree:.3f}" if degree else MISSING for degree in side["degrees"].values()
            )
            rows.append([side["input"], f"{side['value']:.4g}", *degrees])
        return Table("", ("input", "value", *labels), rows, title=title)
    for side in sides:  # each has terms of its own, few of which have a degree above 0
        counting = [pair for pair in side["degrees"].items() if pair[1]]
        for k, (label, degree) in enumerate(counting):
            head = ("", "") if k else (side["input"], f"{side['value']:.4g}")
            rows.append([*head, label, f"{degree:.3f}"])
    return Table("", ("input", "value", "term", "degree"), rows, title=title)


def _rules(unit: Json, least: float) -> Table:
    shown = [rule for rule in unit["rules"] if rule["share"] >= least]
    rows = []
    for rule in shown:
        consequent = f"{rule['consequent']:.6g}"
        consequent = f"{rule['label']} {consequent}" if "label" in rule else consequent
        rows.append([rule["row"], rule["column"], f"{100 * rule['share']:.2f} %", consequent])
    if hidden := unit["rules"][len(shown) :]:
        rest = sum(rule["share"] for rule in hidden)
        rows.append([f"{len(hidden)} more below {100 * least:g} %", "", f"{100 * rest:.2f} %", ""])
    head = (f"if {unit['row']['input']}", f"and {unit['column']['input']}", "share", "consequent")
    output = f"output of fuzzy unit '{unit['unit']}' = {unit['output']:.6g}"
    return Table("", head, rows, lines=[output])


def _command(explanation: Json) -> Table:
    parts = dict(explanation["parts"])
    if "fuzzy" in parts and "output_scale" in explanation:
        line = f"fuzzy, {explanation['units'][-1]['unit']} x {explanation['output_scale']:g}"
        line += " x scheduled law" * ("scheduled" in explanation)
        parts = {line if name == "fuzzy" else name: x for name, x in parts.items()}
    table = _sum("command", parts, explanation["command"], explanation["command_unit"])
    if explanation["accepted"] == explanation["command"]:
        return table
    accepted = ["from the converter", f"{explanation['accepted']:.6g}"]
    return table._replace(rows=[*table.rows, accepted], lines=[CONVERTED])


def _sum(name: str, parts: Json, value: float, unit: str) -> Table:
    rows = [[PARTS.get(part, part), f"{x:.6g}"] for part, x in parts.items()]
    return Table("", ("part", f"value [{unit}]"), [*rows, [name, f"{value:.6g}"]], title=name)
