"""Pages of tables from ``hfc_design.reference``: every key, parameter, signal, metric and part."""

import json
from collections.abc import Iterable, Sequence

from hfc_design.reference.entries import Entry, parts, things

#: Page -> title and what it begins with, an example included.
HEADS = {
    "scenario-keys": (
        "Scenario keys",
        "Every key of a [scenario file](../scenario.md), from the code. Numbers are in the "
        "unit beside them; constraints and tolerances may say their own: "
        "`late_error = \"2 mrad\"`.\n\n"
        '```toml\n[limits]\ncommand = 120.0\n\n[sensors]\nvelocity = "observer"\n'
        "observer_hz = 100.0\n```\n",
    ),
    "plants": (
        "Plants",
        "Every drive and machine that is built in: parameters, signals and its metrics. "
        "A scenario changes parameters by their keys.\n\n"
        "```sh\nhfc design c-axis-ramp --set plant.parameters.spindle_inertia=6.5\n```\n",
    ),
    "controllers": (
        "Controllers",
        "Every kind: what `[controller]` of a scenario may say of it, and what `\"controller\"` of "
        "its design file holds.\n\n```sh\nhfc design c-axis-ramp --controller pid+ff\n```\n",
    ),
    "parts": (
        "Searches, fitnesses, motions, formats",
        "What a scenario names, each with its keys.\n\n"
        "```sh\nhfc design c-axis-ramp --preset lin-lee-1999\n```\n",
    ),
    "design-file": (
        "Design file",
        "What `design.json` holds; a kind's own keys stand with [the controllers](controllers.md)."
        "\n\n```python\nfrom hfc_design import runtime\n\n"
        'controller = runtime.load("runs/mine/design.json")\n```\n',
    ),
    "metrics": (
        "Metrics",
        "What every motion is measured by; in results the unit ends the name, as in "
        "`rms_error_rad`. A plant's own stand with [the plants](plants.md).\n\n"
        "```sh\nhfc score lin-lee-1999-table-1 --json\n```\n",
    ),
}  # fmt: skip
TITLES = {
    "parameter": "Parameters", "signal": "Signals", "metric": "Metrics", "setting": "In a scenario",
    "design": "In a design file",
}  # fmt: skip
GROUPS = {
    "strategy": "Search strategies", "objective": "Fitnesses", "reference": "Motions",
    "format": "Export formats",
}  # fmt: skip
ESCAPED = str.maketrans({mark: f"\\{mark}" for mark in "\\`*_[]<>|{}"})


def table(every: Iterable[Entry]) -> str:
    """A row an entry; a column that none of them fills is left out."""
    heads = ("key", "meaning", "type", "unit", "default")
    rows = [
        (
            f"`{one.key or one.name}`",
            one.meaning.translate(ESCAPED),
            (one.type + (f", {one.allowed}" if one.allowed else "")).translate(ESCAPED),
            ("" if one.unit == "1" else one.unit).translate(ESCAPED),
            "has to be given" if one.required else _default(one),
        )
        for one in every
    ]
    kept = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    lines = [[heads[k] for k in kept], ["---"] * len(kept), *([r[k] for k in kept] for r in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines) + "\n"


def _default(one: Entry) -> str:
    return "" if one.default is None else f"`{json.dumps(one.default, ensure_ascii=False)}`"


def thing(one: Entry, level: str, wanted: Sequence[str]) -> str:
    """A section: what it is, and a table for each of the ``wanted`` parts that it has."""
    source = f" ({one.source})" if one.source and one.source not in one.meaning else ""
    text = f"{level} {one.name}\n\n{one.meaning.translate(ESCAPED)}{source}\n\n"
    for part in wanted:
        if own := [item for item in parts(one.kind, one.name) if item.part == part]:
            text += f"{level}# {TITLES[part]} of {one.name}\n\n{table(own)}"
    return text


def _scenario() -> str:
    """Keys by the table of the file that they stand in; the first lines stand in none."""
    keys = things("key")
    groups: dict[str, list[Entry]] = {}
    for one in keys:
        group = one.name.partition(".")[0]
        alone = "table" not in one.type and group == one.name
        groups.setdefault("The first lines" if alone else group, []).append(one)
    return "".join(f"## {group}\n\n{table(own)}" for group, own in groups.items())


def pages() -> dict[str, str]:
    """Name of the page -> its text."""
    bodies = {
        "scenario-keys": _scenario(),
        "plants": "".join(
            thing(one, "##", ("parameter", "signal", "metric")) for one in things("plant")
        ),
        "controllers": "".join(
            thing(one, "##", ("setting", "design")) for one in things("controller")
        ),
        "parts": "".join(
            f"## {title}\n\n" + "".join(thing(one, "###", ("setting",)) for one in things(kind))
            for kind, title in GROUPS.items()
        ),
        "design-file": table(things("design-key")),
        "metrics": table(things("metric")),
    }
    return {name: f"# {title}\n\n{begin}\n{bodies[name]}" for name, (title, begin) in HEADS.items()}
