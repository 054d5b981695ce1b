"""C99 of a controller that commands a whole machine: what is inside has files of its own."""

from collections.abc import Iterable

from hfc_design.controllers.kind import ControllerRecord, Template, kinds, needed
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.pairing import axes_of
from hfc_design.formats import code, saving
from hfc_design.formats.writing import RESERVED, comment, rendered, signal_meanings, signal_units

#: Ends the names of a controller that all axes have.
EVERY = "axis"


def sources(design: Design) -> dict[str, str]:
    """A folder with ``NAME.h`` and ``NAME.c``, and the same of each controller inside.

    Raises:
        UserError: a kind has no C code, or an input is called like a word of the language.
    """
    if design.kind.controller is None or design.kind.axes is not None:
        return code.sources(design)
    template: Template = needed(design.kind.c, design, code.NO_CODE.format("C"))
    numbers = code.checked_numbers(design)
    axes, name = axes_of(design), code.c_name(design)
    design.commanding(axes)  # or it is none
    parts, files = _parts(design, axes)
    own = template.values(design.controller)
    for member in (one["member"] for one in parts):
        if member in RESERVED["c"] or member in own["own"]:
            raise UserError(f"design {design.name}: an axis named {member} cannot be one in C")
    told = signal_meanings(design)
    values = {
        "name": name,
        "axes": [identifier(axis) for axis in axes],
        "signals": code.signals(design),
        "meanings": dict(zip(told, comment(told.values()), strict=True)),
        "command_unit": signal_units(design).get("command", "unit"),
        "limits": list(design.limits.commands(axes).values()),
        "changes": list(design.changes(axes).values()),
        "path": _sees_path(design.controller, axes),
        "parts": parts,
        "root": False,
        "only_double": code.only_double(numbers, ()),
        "saved": saving.values(design),
        **own,
    }
    for file, text in {f"{name}.h": "header.h.j2", f"{name}.c": "source.c.j2"}.items():
        files[file] = rendered(f"c/machine/{text}", design, template.places, **values)
    return files


def _parts(design: Design, axes: tuple[str, ...]) -> tuple[list[Json], dict[str, str]]:
    """What the templates read of each controller inside, and the files of these.

    Axes that have the same one share its code.
    """
    inside = design.kind.inside
    records = inside.records(design.controller, axes) if inside else {}
    # Rates are limited where the command of the whole is known.
    free = design.limits.without_rate()
    limits = {axis: free.of(axis) if axis else free for axis in records}
    shared = len(records) > 1 and _alike(records.values()) and _alike(limits.values())
    parts: list[Json] = []
    files: dict[str, str] = {}
    for axis, record in records.items():
        ending = EVERY if shared else saving.part(axis)
        changes = {"name": f"{design.name}-{ending}", "controller": record, "limits": limits[axis]}
        own = design.model_copy(update=changes)
        own._axis = axis
        files |= sources(own)
        parts.append(
            {
                "member": saving.part(axis),
                "name": code.c_name(own),
                "axis": axes.index(axis) if axis else None,
                "signals": list(code.signals(own)),
                "path": _sees_path(record, axes),
            }
        )
    return parts, files


def sees_path(design: Design) -> bool:
    """Whether the controller of a machine, or one inside it, has to see the path."""
    return _sees_path(design.controller, axes_of(design))


def _alike(values: Iterable[object]) -> bool:
    first, *others = values
    return all(other == first for other in others)


def _sees_path(record: ControllerRecord, axes: tuple[str, ...]) -> bool:
    """Whether a controller, or one inside it, has to see the path."""
    kind = kinds().get(record.kind)
    inside = kind.inside.records(record, axes).values() if kind.inside else ()
    return kind.path or any(_sees_path(own, axes) for own in inside)
