"""Export formats, and the parts that all writers share: facts of a design, names, templates.

A module in this folder registers formats by a list ``FORMATS``. Exports of the same design have the
same bytes.
"""

import csv
import hashlib
import io
import os
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple, TypeAlias
from xml.sax.saxutils import escape

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from hfc_design import __version__
from hfc_design.codegen.st import literal_of
from hfc_design.controllers.controller import FOLLOWED, units_of
from hfc_design.controllers.kind import require
from hfc_design.controllers.rules import RuleBase, RuleUnit, identifier
from hfc_design.core.checkpoint import synced, write_whole
from hfc_design.core.lock import TEMPORARY
from hfc_design.core.records import RunError, UserError, harmless, option, writing
from hfc_design.files.design import Design, design_json
from hfc_design.files.machine import ALL_PLANTS, PlantSettings
from plants import Drive

HERE = Path(__file__).parent
#: Format -> words that cannot be names in its files.
RESERVED: dict[str, list[str]] = {
    target: words.split()
    for target, words in tomllib.loads((HERE / "reserved.toml").read_text(encoding="utf-8")).items()
}
#: Meanings of the signals that every drive has; the drive's own ``meanings`` describe the others.
MEANINGS = {
    "error": "reference less position",
    "error_rate": "rate of the reference less velocity",
    **FOLLOWED,
}
#: First characters that make a cell a formula in a spreadsheet, unless it is a number.
FORMULA = tuple("=+-@\t\r\n")
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
#: Characters that are markup within a line of Markdown: an underscore in a word is not.
MARKUP = re.compile(r"[\\`*<\[|~]|&(?=#?\w+;)|(?<![^\W_])_|_(?![^\W_])")
#: Content of a file, or contents of a folder by file name.
Content: TypeAlias = "str | bytes | Mapping[str, Content]"


class Format(NamedTuple):
    """Export format of a design."""

    name: str
    text: str  # what it writes, for lists of formats
    #: Design, or its part for one axis -> content. UserError: the format does not fit the kind, or
    #: a name is invalid in it.
    content: Callable[[Design], Content]
    suffix: str = ""  # of the file; "": a folder
    whole: bool = False  # whether one file or folder holds all axes
    note: Callable[[], str] = str  # gives a remark for the user on every export, "": none
    #: Design and names of its axes -> content besides the parts, if each axis has its own part.
    companions: Callable[[Design, Sequence[str]], dict[str, Content]] = lambda design, axes: {}
    ending: str = ""  # of the default name of a folder; "": a dot and the name of the format
    called: bool = False  # whether other code calls a file by its name, which is an identifier
    connects: bool = False  # whether its code can be connected, see ``formats.connection``
    parameters: bool = False  # whether ``content`` takes ``motor`` and ``old``, see ``controls``

    def write(
        self,
        design: Design,
        path: Path,
        connect: Callable[[Design], Design] = lambda design: design,
    ) -> None:
        """Write ``design``; if its axes differ, a folder with a part for each axis.

        ``connect`` turns a part into a connected one, see ``formats.connection``.

        Raises:
            UserError: the format cannot hold this kind of controller.
            RunError: ``path`` cannot be written.
        """
        parts = {"": design} if self.whole else design.by_axis()
        names = {x: identifier(part.name) if self.called else x for x, part in parts.items()}
        files = {f"{names[axis]}{self.suffix}": connect(part) for axis, part in parts.items()}
        contents = {name: self.content(part) for name, part in files.items()}
        if len(contents) == 1:
            write(path, next(iter(contents.values())))
        else:
            write(path, self.companions(design, list(parts)) | contents)


def write(path: Path, content: Content) -> None:
    """Write a file or a folder completely or not at all; other files in the folder stay.

    Raises:
        RunError: it cannot be written.
    """
    if isinstance(content, str | bytes):
        _fill(path, content)
        return
    with writing(path):
        # On the same disk, so that a full disk is found before the first file is in its place.
        near = next(folder for folder in path.absolute().parents if folder.is_dir())
        begin, end = TEMPORARY
        with TemporaryDirectory(end, begin, near) as name:
            _fill(whole := Path(name) / "whole", content)
            _check_room(whole, path)
            path.parent.mkdir(parents=True, exist_ok=True)
            _move(whole, path)


def _fill(path: Path, content: Content) -> None:
    if isinstance(content, str | bytes):
        write_whole(path, content.encode() if isinstance(content, str) else content)
        return
    path.mkdir()
    for name, part in content.items():
        _fill(path / name, part)


def _check_room(whole: Path, path: Path) -> None:
    """Check that no folder lies where a file will be, nor a file where a folder will be."""
    if whole.is_dir() and path.is_dir():
        for inner in whole.iterdir():
            _check_room(inner, path / inner.name)
    elif path.is_dir() or (whole.is_dir() and os.path.lexists(path)):
        there = "folder" if path.is_dir() else "file"
        raise RunError(f"{path}: cannot be written: it is a {there}")


def _move(whole: Path, path: Path) -> None:
    """Move a folder to its place, or its files into an existing folder."""
    if whole.is_dir() and path.is_dir():
        for inner in sorted(whole.iterdir()):
            _move(inner, path / inner.name)
        synced(path)
    else:
        whole.replace(path)
        synced(path.parent)


def rule_base(design: Design) -> RuleBase:
    """Return the functions of the kind that give rule tables; UserError: the kind has none."""
    rules: RuleBase = require(design.kind.rule_base, design, design.kind.no_rules)
    return rules


def rule_units(design: Design) -> list[RuleUnit]:
    """Return the units in evaluation order, output last; UserError as for ``rule_base``."""
    return rule_base(design).units(design.controller)


def signal_units(design: Design) -> dict[str, str]:
    """Return signal -> unit, also of "command"; {} if the plant is unknown or drives differ."""
    drive = _drive(design)
    units = units_of(drive.units) if drive else {}
    return units | design.connected.units if design.connected and units else units


def each_axis(design: Design) -> dict[str, tuple[dict[str, str], dict[str, str]]]:
    """Return axis -> (units, meanings) of all its signals and of its command.

    The only key is "" if they are the same for all axes, or not known.
    """
    if signal_units(design) or design.plant.name not in ALL_PLANTS.known:
        return {"": (signal_units(design), signal_meanings(design))}
    if design.connected:
        return dict(design.connected.each)
    axes = PlantSettings(**design.plant.model_dump()).each()
    return {x.name: (units_of(x.drive.units), MEANINGS | meanings_of(x.drive)) for x in axes}


def signals_read(design: Design) -> dict[str, str]:
    """Return identifier and unit ("" if unknown) of each signal that the controller reads."""
    if design.connected:
        return dict(design.connected.units)
    units = signal_units(design)
    read = require(design.kind.reads, design, "its inputs are not known")(design.controller)
    return {identifier(name): units.get(name, "") for name in read}


def signal_meanings(design: Design) -> dict[str, str]:
    """Return the known meanings of the controller's inputs and of "command"."""
    read = require(design.kind.reads, design, "its inputs are not known")(design.controller)
    drive = _drive(design)
    if design.connected:
        known = (meanings_of(drive) if drive else {}) | design.connected.meanings
        return {x: known[x] for x in (*design.connected.units, "command") if x in known}
    known = MEANINGS | (meanings_of(drive) if drive else {})
    return {identifier(name): known[name] for name in (*read, "command") if name in known}


def meanings_of(drive: Drive) -> dict[str, str]:
    """Return the meanings of a drive's signals, including the velocities of its encoders."""
    return {rate: f"rate of {angle}" for angle, rate in drive.encoders.items()} | drive.meanings


def _drive(design: Design) -> Drive | None:
    """Return the drive of a design's axis, or of all its axes; None if unknown or different."""
    if design.plant.name not in ALL_PLANTS.known:
        return None
    machine = PlantSettings(**design.plant.model_dump()).machine
    if design.axis in machine.axes:  # not if only the scenario has several axes
        return machine.drives[machine.axes.index(design.axis)]
    return machine.drives[0] if len(set(machine.drives)) == 1 else None


def facts(design: Design) -> list[str]:
    """Return lines for the head of a file: the program that made it, and the design."""
    controller = design.controller
    return [
        f"made by hfc-design {__version__}",
        f"design {design.name}, sha256 {hashlib.sha256(design_json(design).encode()).hexdigest()}",
        f"controller {controller.kind} for the plant {design.plant.name}, "
        f"stepped every {controller.sample_time_s!r} s",
    ]


def comment(lines: Iterable[str]) -> list[str]:
    """Return lines that are safe in a comment or a string: nothing in them can end it."""
    return [re.sub(r"[^A-Za-z0-9 .,:;_+-]", "_", line) for line in lines]


def plain(text: str) -> str:
    """Return a text for a line of Markdown; only characters that would be markup are escaped."""
    return MARKUP.sub(r"\\\g<0>", harmless(text)).strip()


def head(design: Design, notes: Iterable[str] = ()) -> list[str]:
    """Return ``facts`` and notes as lines that are safe in a comment."""
    return comment([*facts(design), *notes])


def csv_text(rows: Iterable[Sequence[object]]) -> str:
    """Return rows as CSV; formulas of a spreadsheet get an apostrophe (OWASP, CSV injection)."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerows([_text(x) if isinstance(x, str) else x for x in row] for row in rows)
    return buffer.getvalue()


def _text(cell: str) -> str:
    formula = cell[:1] in FORMULA and not NUMBER.fullmatch(cell)
    return "'" * formula + cell.replace("\r", "\n")  # the csv module quotes line feeds


def check_names(target: str, names: Iterable[str], clash: str) -> None:
    """Check that names are identifiers of IEC 61131-3, all different, and not reserved in a format.

    Upper and lower case are not distinguished. ``clash`` is the message on a ``{name}`` that equals
    the ``{other}``: an earlier name, or "a word of the language".

    Raises:
        UserError: a name breaks one of these rules.
    """
    taken = dict.fromkeys(RESERVED.get(target, ()), "a word of the language")
    for name in names:
        if not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name):
            rule = "a letter, then letters, digits and single underscores between them"
            fault = f"{name!r} must be an identifier: {rule}; rename it in the design"
            raise UserError(f"{option('to', target)}: {fault}")
        if other := taken.get(name.casefold()):
            message = clash.format(name=name, other=other)
            raise UserError(f"{option('to', target)}: {message}; rename it in the design file")
        taken[name.casefold()] = name


def rendered(template: str, design: Design, /, **values: object) -> str:
    """Return a rendered template of ``formats/templates``; values that most need are added.

    Templates write ``x | number`` for a float that reads back bit for bit, ``x | xml`` for a text
    between XML tags, and ``x | quoted`` for a text in an attribute.
    """
    usual = {
        "head": head(design),
        "every": design.controller.sample_time_s,
        "limit": design.limits.command,
        "change": design.changes([design.axis])[design.axis],  # largest in a sample
        "command_unit": signal_units(design).get("command", ""),
    }
    return _templates().get_template(template).render(usual | values)


@cache
def _templates() -> Environment:
    """Return the environment that reads templates, each of them once."""
    environment = Environment(
        loader=FileSystemLoader(HERE / "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # templates use the filters below
    )
    environment.filters.update(literal=literal_of, plain=plain, harmless=harmless, xml=escape)
    environment.filters["number"] = lambda value: repr(float(value))
    environment.filters["quoted"] = lambda text: escape(text, {'"': "&quot;"})
    environment.filters["hyphens"] = lambda name: name.replace("_", "-")
    return environment


def _tables(design: Design) -> dict[str, str]:
    """Return one file per rule table for a spreadsheet, and ``manifest.csv`` with the wiring."""
    tables = rule_base(design).tables(design.controller)
    return {name: csv_text(rows) for name, rows in tables.items()}


TABLES = "a folder with one labelled rule table per unit, and manifest.csv"
FORMATS = (
    Format("json", "the design file itself", lambda design: design_json(design) + "\n", whole=True),
    Format("csv", TABLES, _tables),
)
