"""Tables of an explanation that fit into 80 columns."""

from rich.table import Table

from hfc_design.core.console import plain_table, show_whole, terminal
from hfc_design.core.numbers import Json

#: Share of a command -> its name in an explanation.
PARTS = {
    "proportional": "kp error",
    "derivative": "kd error_rate",
    "fuzzy": "fuzzy",
    "integral": "integral",
    "compensation": "low-velocity compensation",
}
CONVERTED = (
    "From the converter: the command as the drive receives it, rounded to whole steps\nor limited."
)
#: Columns for the degrees of all terms beside one another.
WIDEST = 42


def show(explanation: Json, least: float) -> None:
    """Print the result of ``explain.explanation``, and the count of rules below ``least``."""
    console = terminal()
    console.print(f"design {explanation['design']}, kind {explanation['kind']}", highlight=False)
    if "inside" in explanation:
        console.print(
            f"These are the wrapped controllers; what {explanation['inside']} adds depends on "
            "the whole machine.",
            highlight=False,
        )
    if explanation["adaptation_held"]:
        console.print(
            "Nothing adapts: the rules that fired in the previous sample are not known. "
            "Give\nthe previous sample in another --at to see the adaptation.",
            highlight=False,
        )
    if explanation["rate_left_out"]:
        console.print(
            "The rate of the command is not limited: the previous command is not "
            "known.\nGive the previous sample in another --at.",
            highlight=False,
        )
    _signals(explanation)
    for unit in explanation["units"]:
        _unit(unit, least)
    _command(explanation)


def _signals(explanation: Json) -> None:
    scaled = ("scale", "scaled", "clamped") if "inputs" in explanation else ()
    table = _table("signals", "signal", "value", "unit", *scaled)
    table.columns[2].justify = "left"
    units = explanation["units_of_signals"]
    inputs = {item["name"]: item for item in explanation.get("inputs", ())}
    readings = {name: item["reading"] for name, item in inputs.items()} | explanation["signals"]
    called = {signal: name for name, signal in explanation.get("names", {}).items()}
    for name, reading in readings.items():
        label = f"{called[name]} ({name})" if name in called else name
        row = [label, f"{reading:.6g}", units.get(name, "")]
        if name in inputs:
            scaled = inputs[name]["scaled"]
            clamped = f"{min(max(scaled, -1.0), 1.0):.4f}"
            row += [f"{inputs[name]['scale']:.4g}", f"{scaled:.4f}", clamped]
        table.add_row(*row)
    show_whole(table)


def _unit(unit: Json, least: float) -> None:
    row, column = unit["row"], unit["column"]
    title, labels = f"fuzzy unit '{unit['unit']}': degrees of the terms", list(row["degrees"])
    if labels == list(column["degrees"]) and sum(max(len(x), 5) + 1 for x in labels) <= WIDEST:
        table = _table(title, "input", "value", *labels)
        for side in (row, column):
            degrees = (f"{degree:.3f}" if degree else "-" for degree in side["degrees"].values())
            table.add_row(side["input"], f"{side['value']:.4g}", *degrees)
    else:  # each has its own, of which few count
        table = _table(title, "input", "value", "term", "degree")
        table.columns[2].justify = "left"
        for side in (row, column):
            counting = [pair for pair in side["degrees"].items() if pair[1]]
            for k, (label, degree) in enumerate(counting):
                head = ("", "") if k else (side["input"], f"{side['value']:.4g}")
                table.add_row(*head, label, f"{degree:.3f}")
    show_whole(table)
    shown = [rule for rule in unit["rules"] if rule["share"] >= least]
    table = _table(None, f"if {row['input']}", f"and {column['input']}", "share", "consequent")
    table.columns[1].justify = "left"
    for rule in shown:
        share, consequent = f"{100 * rule['share']:.2f} %", f"{rule['consequent']:.6g}"
        consequent = f"{rule['label']} {consequent}" if "label" in rule else consequent
        table.add_row(rule["row"], rule["column"], share, consequent)
    hidden = unit["rules"][len(shown) :]
    if hidden:
        rest = sum(rule["share"] for rule in hidden)
        number = f"{len(hidden)} more below {100 * least:g} %"
        table.add_row(number, "", f"{100 * rest:.2f} %", "", style="dim")
    show_whole(table, 2)
    terminal().print(
        f"  output of fuzzy unit '{unit['unit']}' = {unit['output']:.6g}\n", highlight=False
    )


def _command(explanation: Json) -> None:
    unit = explanation["command_unit"]
    if "scheduled" in explanation:
        law = _table("scheduled law", "part", f"value [{unit}]")
        for name, value in explanation["scheduled"].items():
            law.add_row(PARTS.get(name, name), f"{value:.6g}")
        law.add_section()
        law.add_row("scheduled law", f"{sum(explanation['scheduled'].values()):.6g}")
        show_whole(law)
    table = _table("command", "part", f"value [{unit}]")
    for name, value in explanation["parts"].items():
        line = PARTS.get(name, name)
        if name == "fuzzy" and "output_scale" in explanation:
            line = f"fuzzy, {explanation['units'][-1]['unit']} x {explanation['output_scale']:g}"
            line += " x scheduled law" * ("scheduled" in explanation)
        table.add_row(line, f"{value:.6g}")
    table.add_section()
    table.add_row("command", f"{explanation['command']:.6g}")
    if explanation["accepted"] != explanation["command"]:
        table.add_row("from the converter", f"{explanation['accepted']:.6g}")
    show_whole(table)
    if explanation["accepted"] != explanation["command"]:
        terminal().print(CONVERTED, highlight=False)


def _table(title: str | None, *names: str) -> Table:
    table = plain_table(title=title, title_style="bold")
    for k, name in enumerate(names):
        table.add_column(name, justify="right" if k else "left", no_wrap=True)
    return table
