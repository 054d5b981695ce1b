"""What every format is written with: facts of a design, words, templates, folders.

The same design gives the same bytes.
"""

import csv
import hashlib
import io
import re
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path

from jinja2 import ChoiceLoader, DictLoader, Environment, FileSystemLoader, StrictUndefined

from hfc_design import __version__
from hfc_design.controllers.kind import needed
from hfc_design.controllers.rules import RuleBase, RuleUnit
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError
from hfc_design.files.design import Design, design_json
from hfc_design.files.machine import ALL_PLANTS, PlantSettings

HERE = Path(__file__).parent
#: What a kind lacks that has no code in other languages.
NO_CODE = "json holds its gains, its law is in Python only"
#: Format -> words that no name in its files can be.
RESERVED: dict[str, list[str]] = {
    target: words.split()
    for target, words in tomllib.loads((HERE / "reserved.toml").read_text(encoding="utf-8")).items()
}


def rule_base(design: Design) -> RuleBase:
    """What the design's kind tells of its rule tables.

    Raises:
        UserError: the design is of a kind without rule tables.
    """
    found: RuleBase = needed(design.kind.rules, design, "no rule tables")
    return found


def rule_units(design: Design) -> list[RuleUnit]:
    """The units in evaluation order, the last one gives the output; UserError as ``rule_base``."""
    return rule_base(design).units(design.controller)


def signal_units(design: Design) -> dict[str, str]:
    """Unit of each signal of the design's plant, of "error" and "command" too; {} if unknown."""
    if design.plant.name not in ALL_PLANTS.known:
        return {}
    machine = PlantSettings(**design.plant.model_dump()).machine
    if design.axis:
        return machine.drives[machine.axes.index(design.axis)].units
    return machine.drives[0].units if len(set(machine.drives)) == 1 else {}


def facts(design: Design) -> list[str]:
    """Lines for the head of a file: what made it, and from which design."""
    controller = design.controller
    return [
        f"made by hfc-design {__version__}",
        f"design {design.name}, sha256 {hashlib.sha256(design_json(design).encode()).hexdigest()}",
        f"controller {controller.kind} for the plant {design.plant.name}, "
        f"stepped every {controller.sample_time_s!r} s",
    ]


def comment(lines: list[str]) -> list[str]:
    """Lines for a comment or a string; nothing in them can end it."""
    return [re.sub(r"[^A-Za-z0-9 .,:;_+-]", "_", line) for line in lines]


def csv_text(rows: Iterable[Sequence[object]]) -> str:
    """Rows as CSV."""
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(rows)
    return buffer.getvalue()


def rendered(
    template: str, design: Design, places: Sequence[Path | dict[str, str]] = (), /, **values: object
) -> str:
    """A template of ``places`` or of ``formats/templates``, with ``design`` and its ``facts``.

    ``x | number`` writes a float so that it reads back bit for bit.
    """
    loaders = [DictLoader(p) if isinstance(p, dict) else FileSystemLoader(p) for p in places]
    environment = Environment(
        loader=ChoiceLoader([*loaders, FileSystemLoader(HERE / "templates")]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # no markup, and nothing that a user wrote freely
    )
    environment.filters["number"] = lambda value: repr(float(value))
    environment.filters["hyphens"] = lambda name: name.replace("_", "-")
    return environment.get_template(template).render(design=design, facts=facts(design), **values)


def make_folder(path: Path) -> None:
    """Make the folder ``path``, if need be; RunError: it cannot be written."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{path}: cannot be written: {error.strerror or error}") from None


def write_folder(path: Path, texts: dict[str, str]) -> None:
    """Write ``texts`` by file name into the folder ``path``; RunError: it cannot be written."""
    make_folder(path)
    for name, text in texts.items():
        write_whole(path / name, text.encode())
