"""Import of fuzzy controllers of other programs, as designs with which a search can start.

An imported design computes the same as the file, up to rounding; beyond the ranges of its inputs,
where programs differ, its outermost terms stay 1. What a design cannot represent is refused, but
outputs with shaped terms (Mamdani), and others on request, are sampled; the deviation is reported.
``design_that_learned`` imports the numbers that exported code has learned on a machine.
"""

import hashlib
import re
from os.path import isdir
from pathlib import Path

from hfc_design.controllers.per_axis import PerAxisDesign
from hfc_design.core.numbers import Json, number_of
from hfc_design.core.records import UserError, option
from hfc_design.core.texts import as_user_error, content, decoded
from hfc_design.files.design import Design, with_learned
from hfc_design.files.loop_setup import axes_of, load_design
from hfc_design.formats.reading import csv_tables, fis, fll
from hfc_design.formats.reading.design_of import (
    Wish,
    assumed,
    assumptions_text,
    checked_name,
    design_of,
)
from hfc_design.formats.reading.sampling import compared_on, deviation_told, left_out_told, sampled
from hfc_design.formats.reading.system import System
from hfc_design.formats.saving import taken

__all__ = ["Wish", "assumed", "assumptions_text", "deviation_told", "imported", "left_out_told"]

#: File suffix -> reader of the language.
LANGUAGES = {".fll": fll, ".fis": fis}
#: Suffixes of files with learned numbers: of ``NAME_save``, and of ``halcmd save param``.
LEARNT = (".txt", ".hal")
#: Learned number as ``halcmd save`` writes it; its name begins with the axis if there are several.
PARAMETER = re.compile(
    r"setp\s+(?:(?P<axis>\w+)-)?controller\.learnt-(?P<place>[0-9]{1,9})\s+(?P<value>\S+)"
)


def imported(path: Path, wish: Wish) -> Design:
    """Return the design in the file or folder ``path``, completed by ``wish``.

    Raises:
        UserError: the file cannot be read, or contains something that a design cannot represent.
    """
    ending = ".csv" if isdir(path) else path.suffix.lower()
    if ending in LEARNT:
        return _learned(path, ending, wish)
    if ending not in (*LANGUAGES, ".csv"):
        known = "must be a .fll, .fis, .txt or .hal file, or a folder of .csv tables"
        raise UserError(f"{path}: {known}")
    if wish.axis is not None:
        fault = "applies to the learned state of an axis, a .txt or .hal"
        raise UserError(f"{option('axis', wish.axis)}: {fault}")
    with as_user_error(path):
        files = csv_tables.files(path) if ending == ".csv" else [path]
        texts, digests = {}, {}
        for file in files:
            with as_user_error(file):
                data = content(file)
                texts[file.name] = _text(data)
            digests[file.name] = hashlib.sha256(data).hexdigest()
        system, sample = _system(ending, texts, wish)
        return design_of(system, wish, path, digests, sample)


def _text(data: bytes) -> str:
    """Return the text of a file from its bytes; ValueError: it is not text, or is empty."""
    text = decoded(data, "utf-8-sig")
    if not text.strip():
        raise ValueError("is empty")
    return text


def _system(ending: str, texts: dict[str, str], wish: Wish) -> tuple[System, Json]:
    """Return the system of a file and {}, or a sample of its output and a report on the deviation.

    Raises:
        UserError, ValueError: a design cannot represent it; the message says if it can be sampled.
    """
    if ending == ".csv":
        if wish.terms:
            raise UserError(f"{option('terms')}: does not apply to .csv tables")
        if wish.output is not None:
            fault = "does not apply to .csv tables, which have one output"
            raise UserError(f"{option('output', wish.output)}: {fault}")
        return csv_tables.read(texts), {}
    (text,) = texts.values()
    reader = LANGUAGES[ending]
    if wish.terms or reader.is_mamdani(text):
        return sampled(reader.rule_base(text, wish.output), wish.terms)
    try:
        return reader.read(text, wish.output), {}
    except ValueError as fault:
        try:
            base = reader.rule_base(text, wish.output)
            compared_on(base, None)
        except ValueError:
            raise fault from None
        # Two rules with the same condition are a mistake, so sampling is not proposed.
        conditions = [sorted(map(str, rule.condition)) for rule in base.rules]
        if any(one in conditions[:k] for k, one in enumerate(conditions)):
            raise
        message = "to sample it into triangles; the deviation is then reported"
        raise ValueError(f"{fault}; use {option('terms', 7)} {message}") from None


def _learned(path: Path, ending: str, wish: Wish) -> Design:
    """Return the design ``wish.like`` with the values that its code learned on a machine."""
    if wish.like is None:
        raise UserError(f"{option('like')}: must name the design whose code wrote {path}")
    others = wish._replace(like=None, axis=None, name=None)
    if odd := next((key for key, value in others._asdict().items() if value), None):
        given = option("signal" if odd == "signals" else odd, argument=odd)
        raise UserError(f"{given}: must be left out, it is that of {wish.like}")
    design = load_design(wish.like)
    with as_user_error(path):
        data = content(path)
        source = {"source": path.name, "sha256": hashlib.sha256(data).hexdigest()}
        design = design_that_learned(_text(data), ending, design, wish.axis, source)
    names = {} if wish.name is None else {"name": checked_name(wish.name)}
    return design.model_copy(update=names)


def design_that_learned(
    text: str, ending: str, design: Design, axis: str | None, source: dict[str, str]
) -> Design:
    """Return ``design`` with the learned numbers in the ``text`` of a file with suffix ``ending``.

    ``axis`` names one of several axes; ``source`` is stored in the provenance.

    Raises:
        UserError, ValueError: the file holds no such numbers, or they are not of this design.
    """
    parts = design.by_axis()
    if axis is None and len(parts) > 1:
        known = ", ".join(parts)
        raise UserError(f"{option('axis')}: must name the axis of the state; available: {known}")
    if axis is not None:
        # A controller that commands all axes has one state.
        together = design.kind.controller and not design.kind.axis_records
        axes = () if together else axes_of(design)
        if axis not in axes:
            known = ", ".join(axes) or "one state for all axes"
            raise UserError(f"{option('axis', axis)}: unknown axis; available: {known}")
    words = re.split(r"[\s,;]+", text.strip())
    numbers = [*map(number_of, words)] if ending == ".txt" else _parameters(text, axis)
    design_of_part = taken(parts.get(axis or "", design), numbers)
    if axis is not None:
        each = {name: parts.get(name, design).controller for name in axes}
        design_of_part = PerAxisDesign(
            sample_time_s=design_of_part.sample_time_s, axes=each | {axis: design_of_part}
        )
    return with_learned(design, design_of_part, source)


def _parameters(text: str, axis: str | None) -> list[float]:
    """Return the learned numbers of ``axis`` (None: of all axes) in the text of a HAL file."""
    numbers = {}
    for line in text.splitlines():
        one = PARAMETER.match(line.strip())
        if one and one["axis"] == (axis and re.sub(r"\W", "_", axis)):
            numbers[int(one["place"])] = number_of(one["value"])
    if not numbers:
        name = f"{axis}-controller" if axis else "controller"
        raise ValueError(f"must have a parameter {name}.learnt-00, as printed by halcmd save param")
    missing = next((k for k in range(len(numbers)) if k not in numbers), None)
    if missing is not None:
        raise ValueError(f"must have a parameter learnt-{missing:02}")
    return [numbers[k] for k in range(len(numbers))]
