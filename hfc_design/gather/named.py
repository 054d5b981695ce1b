"""What a scenario names, as entries: controllers, strategies, objectives, references, metrics."""

import importlib
import inspect
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

from pydantic import BaseModel

from hfc_design.controllers.kind import ControllerRecord, ControllerSettings, Kind
from hfc_design.gather.comments import Comment, comments_of, said
from hfc_design.gather.fields import fields_of
from hfc_design.gather.texts import first_line, source_in
from hfc_design.objectives.measures import Measure
from hfc_design.objectives.objective import Objective, ObjectiveSettings
from hfc_design.reference.entries import (
    CONTROLLER,
    METRIC,
    OBJECTIVE,
    REFERENCE,
    STRATEGY,
    Entry,
)
from hfc_design.search.strategy import Strategy

#: A controller inside another one, or one to begin with, is told of under its own name.
ELSEWHERE = (ControllerRecord, ControllerSettings)


def kind_entries(kind: Kind) -> Iterator[Entry]:
    """The entries of a kind of controller: what is searched, what stands in a design file."""
    texts = [_law_text(kind), kind.summary]
    found = [*filter(None, map(source_in, texts))]
    source = max(found, key=len, default="")  # the one that has an equation too
    head = Entry(CONTROLLER, kind.name)
    yield head._replace(meaning=kind.summary, source=source)
    if kind.settings is not None:
        own = head._replace(part="setting")
        yield from fields_of(kind.settings, "controller.", own, (ControllerRecord,))
        yield from _ranges(kind.settings, own)
    named = _told_elsewhere(kind)
    for entry in fields_of(kind.record, "controller.", head._replace(part="design"), ()):
        told = named.get(entry.key.rpartition(".")[2]) if not entry.meaning else None
        yield entry if told is None else entry._replace(meaning=told.meaning, unit=told.unit)


def _law_text(kind: Kind) -> str:
    """What the module of a kind's law says of it."""
    package = kind.record.__module__.removesuffix(".record")
    if find_spec(package) is None or not hasattr(sys.modules[package], "__path__"):
        return ""  # a user's own
    if find_spec(f"{package}.law") is None:
        return ""
    return inspect.getdoc(importlib.import_module(f"{package}.law")) or ""


def _ranges(settings: type[Any], head: Entry) -> Iterator[Entry]:
    """Where a search of a few gains looks, if nothing else is told."""
    own = getattr(settings, "own_ranges", None)
    if own is None:
        return
    said = comments_of(type(own))
    for name, pair in own._asdict().items():
        told = said.get(name, Comment())
        yield head._replace(
            key=f"controller.ranges.{name}",
            type="list of numbers",
            unit=told.unit,
            default=list(pair),
            allowed="[low, high]",
            meaning=told.meaning,
        )


def _told_elsewhere(kind: Kind) -> dict[str, Comment]:
    """Comments on the gains of a kind whose record was made of them."""
    own = getattr(kind.settings, "own_ranges", None)
    return {} if own is None else comments_of(type(own))


def strategy_entries(strategy: Strategy) -> Iterator[Entry]:
    """The entries of a search strategy."""
    module = sys.modules.get(strategy.settings.__module__)
    text = first_line(inspect.getdoc(module) or "" if module else "")
    head = Entry(STRATEGY, strategy.name)
    yield head._replace(meaning=strategy.summary, source=source_in(text))
    yield from fields_of(strategy.settings, "search.", head._replace(part="setting"))


def objective_entries(objective: Objective) -> Iterator[Entry]:
    """The entries of an objective."""
    module = sys.modules.get(objective.settings.__module__)
    own = objective.settings is not ObjectiveSettings
    text = first_line(inspect.getdoc(module) or "" if module and own else "")
    head = Entry(OBJECTIVE, objective.name)
    told = said(objective.meaning or objective.title).meaning
    yield head._replace(meaning=told, unit=objective.unit, source=source_in(text))
    yield from fields_of(objective.settings, "fitness.", head._replace(part="setting"))


def reference_entries(record: type[BaseModel], passed: tuple[type[Any], ...]) -> Iterator[Entry]:
    """The entries of a kind of reference."""
    head = Entry(REFERENCE, str(record.model_fields["kind"].default))
    yield head._replace(meaning=first_line(inspect.getdoc(record) or ""))
    setting = head._replace(part="setting")
    yield from fields_of(record, "reference.", setting, passed)


def metric_entry(one: Measure) -> Entry:
    """The entry of a measure that a scenario can name."""
    meaning = one.meaning.replace("within 0", "within the band that is told beside it")
    return Entry(METRIC, one.name, type="number", unit=one.unit, meaning=meaning)
