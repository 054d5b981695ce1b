"""Sets of designs that are compared: their names, and their differences."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from os.path import exists
from pathlib import Path
from typing import Any, TypeAlias

from hfc_design.controllers.kinds import KINDS
from hfc_design.core.arguments import check_type
from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError, harmless
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.labels import run_label
from hfc_design.files.loop_setup import load_design, machine
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.files.transfer import dotted, states_machine

#: Several designs, or designs by the names that they are to have.
AnyDesigns: TypeAlias = Sequence[AnyDesign] | Mapping[str, AnyDesign]


def labelled(designs: AnyDesigns) -> dict[str, Design]:
    """Return designs by distinct names.

    A design has its own name, or its label if it is a run of a batch. Designs with equal names have
    that of their file or run folder instead, with as many parent folders as necessary.

    Raises:
        UserError: there is no such design, one is given twice, or is a kind of controller.
    """
    if isinstance(designs, Mapping):
        return {name: load_design(_no_kind(design)) for name, design in designs.items()}
    several = isinstance(designs, Sequence) and not isinstance(designs, str)
    given: Sequence[AnyDesign] = [*designs] if several else [designs]  # type: ignore[list-item]
    for one in given:
        check_type(one, (str, Path, Design), "a design or the name of one")
    for k, one in enumerate(given):
        if any(_same(one, other) for other in given[:k]):
            name = one.name if isinstance(one, Design) else one
            raise UserError(f"{name}: is listed twice")
    loaded = [load_design(_no_kind(one)) for one in given]
    paths = [() if isinstance(one, Design) or not exists(one) else _parts(one) for one in given]
    labels = ["" if isinstance(one, Design) else run_label(one) for one in given]
    pairs = zip(labels, loaded, strict=True)
    names = apart([name or design.name for name, design in pairs], paths)
    for k, name in enumerate(names):  # equal names that remain, of designs without files
        free = (name, *(f"{name} ({n})" for n in range(2, len(names) + 1)))
        names[k] = next(label for label in free if label not in names[:k])
    return dict(zip(names, loaded, strict=True))


def apart(names: Sequence[str], paths: Sequence[tuple[str, ...]]) -> list[str]:
    """Return the names; equal ones are replaced by ends of their paths, as long as necessary."""
    labels = [*names]
    for deep in range(1, max(map(len, paths), default=0) + 1):
        same = Counter(labels)
        labels = [
            harmless("/".join(parts[-deep:])) if parts and same[name] > 1 else name
            for parts, name in zip(paths, labels, strict=True)
        ]
    return labels


def _parts(name: str | Path) -> tuple[str, ...]:
    """Return the parts of a path that may name a design: without ".json" and "design.json"."""
    path = Path(name)
    whole = path.resolve().with_name(path.resolve().name.removesuffix(".json"))
    return whole.parts[1:-1] if whole.name == "design" and path.is_file() else whole.parts[1:]


def _same(one: AnyDesign, other: AnyDesign) -> bool:
    """Return True for the same design object, or for two names of the same file or folder."""
    if isinstance(one, Design) or isinstance(other, Design):
        return one is other
    a, b = Path(one), Path(other)
    return str(one) == str(other) or (exists(a) and exists(b) and a.samefile(b))


def _no_kind(one: AnyDesign) -> AnyDesign:
    if isinstance(one, str) and one in KINDS.names() and not exists(one):
        raise UserError(
            f"{one}: is a kind of controller, not a design; make one with hfc design "
            f"SCENARIO --controller {one} --out runs/mine and then compare runs/mine"
        )
    return one


def shared_machine(designs: Mapping[str, Design], scenario: Scenario) -> Scenario:
    """Return the scenario on the whole machine of the first design, with the scenario's changes.

    Raises:
        UserError: a design is for another plant or sample time.
    """
    plant = machine(next(iter(designs.values())), scenario)
    for design in designs.values():
        machine(design, scenario)
    return scenario.model_copy(update={"plant": PlantSettings(**plant.in_full())})


def own_machine(name: str, scenario: Scenario, shared: Scenario) -> str | None:
    """Return a line on how the ``shared`` machine differs from the scenario's; None: not at all."""
    changes = "; ".join(_machines(shared.plant, scenario.plant, "in the scenario"))
    return f"all on the machine of {name}: {changes}" if changes else None


def differences(design: Design, scenario: Scenario, shared: Scenario) -> Iterator[str]:
    """Yield lines on limits that a design keeps, and on what differs from what it was made for."""
    limits = {"command": shared.units.signals["command"]}
    here = dotted(shared.limits.model_dump())
    design_limits = dotted(design.limits.model_dump(exclude_none=True))
    if changed := _changed(design_limits, {key: here.get(key) for key in design_limits}, limits):
        yield f"the controller applies its own limits: {changed}"
    if design.plant.name != shared.plant.name:
        yield f"made for the plant {design.plant.name}, here {shared.plant.name}"
    other = _machines(machine(design, scenario), shared.plant, "here")
    for changed in other if states_machine(design) else ():
        yield f"made for another machine: {changed}"
    original: Any = design.provenance.get("scenario")
    with suppress(UserError, ValueError):  # the scenario is of an earlier version, or edited
        if isinstance(original, str):
            original = load_scenario(original).model_dump(mode="json")
        whose = {"limits": "other drive limits", "sensors": "other sensors"}
        for key, named in whose.items() if isinstance(original, dict) else ():
            part = getattr(shared, key)
            was = type(part).model_validate(original.get(key) or {})
            made, here = (dotted(x.model_dump(mode="json")) for x in (was, part))
            if changed := _changed(made, here, limits):
                yield f"made with {named}: {changed}"


def _machines(made: PlantSettings, here: PlantSettings, where: str) -> Iterator[str]:
    """Yield the differences between two machines, a line for each axis that differs."""
    axes = here.each()
    for before, other in zip(made.each(), axes, strict=True):
        head = f"{other.name}." if len(axes) > 1 else ""
        pair = before.parameters._asdict(), other.parameters._asdict()
        if changed := _changed(*pair, other.drive.parameter_units, head, where):
            yield changed


def _changed(
    made: Json, here: Json, units: Mapping[str, str], head: str = "", where: str = "here"
) -> str:
    """Return the differences between two tables as a text, or ""; ``head`` precedes each name."""
    changes = []
    for key in {**made, **here}:
        if made.get(key) != here.get(key):
            then, now = ("none" if x.get(key) is None else x[key] for x in (made, here))
            unit = units.get(key, "")
            changes.append(f"{head}{key} {then}, {where} {now}{unit and f' {unit}'}")
    return "; ".join(changes)
