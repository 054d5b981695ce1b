"""An explanation for a person: tables that fit into 80 columns."""

from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from hfc_design.core.console import terminal


def show(found: dict[str, Any], least: float) -> None:
    """Print what ``explain.explanation`` found; rules below the share ``least`` are counted."""
    console = terminal()
    console.print(f"design {found['design']}, kind {found['kind']}", highlight=False)
    if found["adaptation_held"]:
        console.print(
            "Nothing adapts: which rules fired in the sample before is not known. Give that\n"
            "sample in an --at of its own to see what the adaptation makes of it.",
            highlight=False,
        )
    _signals(console, found)
    for unit in found["units"]:
        _unit(console, unit, least)
    _command(console, found)


def _signals(console: Console, found: dict[str, Any]) -> None:
    table = _table("signals")
    table.add_column("signal", no_wrap=True)
    names = ("reading", "unit", "scale", "scaled", "clamped")
    for name in names if "inputs" in found else names[:2]:
        table.add_column(name, justify="left" if name == "unit" else "right", no_wrap=True)
    units = found["units_of_signals"]
    inputs = {item["name"]: item for item in found.get("inputs", ())}
    readings = {name: item["reading"] for name, item in inputs.items()} | found["signals"]
    for name, reading in readings.items():
        row = [name, f"{reading:.6g}", units.get(name, "")]
        if name in inputs:
            scaled = inputs[name]["scaled"]
            clamped = f"{min(max(scaled, -1.0), 1.0):.4f}"
            row += [f"{inputs[name]['scale']:.4g}", f"{scaled:.4f}", clamped]
        table.add_row(*row)
    console.print(table)


def _unit(console: Console, unit: dict[str, Any], least: float) -> None:
    row, column = unit["row"], unit["column"]
    table = _table(f"{unit['unit']}: degrees of its terms")
    table.add_column("input", no_wrap=True)
    table.add_column("value", justify="right", no_wrap=True)
    for label in row["degrees"]:
        table.add_column(label, justify="right", overflow="ellipsis", no_wrap=True)
    for side in (row, column):
        degrees = (f"{degree:.3f}" if degree else "-" for degree in side["degrees"].values())
        table.add_row(side["input"], f"{side['value']:.4g}", *degrees)
    console.print(table)
    shown = [rule for rule in unit["rules"] if rule["share"] >= least]
    table = _table(None)
    table.add_column(f"if {row['input']}", no_wrap=True)
    table.add_column(f"and {column['input']}", no_wrap=True)
    table.add_column("share", justify="right", no_wrap=True)
    table.add_column("consequent", justify="right", no_wrap=True)
    for rule in shown:
        share, consequent = f"{100 * rule['share']:.2f} %", f"{rule['consequent']:.6g}"
        table.add_row(rule["row"], rule["column"], share, consequent)
    hidden = unit["rules"][len(shown) :]
    if hidden:
        rest = sum(rule["share"] for rule in hidden)
        number = f"{len(hidden)} more below {100 * least:g} %"
        table.add_row(number, "", f"{100 * rest:.2f} %", "", style="dim")
    console.print(table)
    console.print(f"  {unit['unit']} = {unit['output']:.6g}\n", highlight=False)


def _command(console: Console, found: dict[str, Any]) -> None:
    unit = found["command_unit"]
    table = _table(f"command [{unit}]")
    table.add_column("part", no_wrap=True)
    table.add_column(unit, justify="right", no_wrap=True)
    lines = {
        "proportional": "kp error",
        "derivative": "kd error_rate",
        "fuzzy": "fuzzy",
        "integral": "integral",
        "compensation": "low-velocity compensation",
    }
    for name, value in found["parts"].items():
        line = lines[name]
        if name == "fuzzy" and "output_scale" in found:
            line = f"fuzzy, {found['units'][-1]['unit']} x {found['output_scale']:g}"
        table.add_row(line, f"{value:.6g}")
    table.add_section()
    table.add_row("command", f"{found['command']:.6g}")
    if found["accepted"] != found["command"]:
        table.add_row("from the converter", f"{found['accepted']:.6g}")
    console.print(table)


def _table(title: str | None) -> Table:
    return Table(
        title=title,
        title_justify="left",
        title_style="bold",
        box=SIMPLE_HEAD,
        show_edge=False,
        padding=0,  # the box separates columns by a space, so that seven terms fit
    )
