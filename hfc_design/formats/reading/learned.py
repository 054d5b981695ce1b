"""Reads what a controller has learnt on a machine: the numbers of its C code, or HAL's."""

import re

from hfc_design.controllers.per_axis import PerAxisDesign
from hfc_design.core.numbers import number_of
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.learning import with_learned
from hfc_design.formats.saving import taken

#: Ending of a file -> what it is.
ENDINGS = {".txt": "numbers of NAME_save", ".hal": "what halcmd save param prints"}
#: A parameter of the component, of the axis in its name, as ``halcmd save`` writes it.
PARAMETER = re.compile(
    r"setp\s+(?:(?P<axis>\w+)-)?controller\.learnt-(?P<place>[0-9]{1,9})\s+(?P<value>\S+)"
)


def design_that_learned(
    text: str, ending: str, design: Design, axis: str | None, told: dict[str, str]
) -> Design:
    """The ``design`` with what stands in a file; of several axes the ``axis`` that it is of.

    Raises:
        UserError, ValueError: the file holds no such numbers, or they are not of this design.
    """
    parts = design.by_axis()
    if axis is None and len(parts) > 1:
        raise UserError(f"--axis: has to say whose state that is; there is {', '.join(parts)}")
    if axis is not None:
        axes = _axes(design)
        if axis not in axes:
            known = ", ".join(axes) or "one state for all"
            raise UserError(f"--axis {axis}: there is {known}")
    numbers = _numbers(text) if ending == ".txt" else _parameters(text, axis)
    found = taken(parts.get(axis or "", design), numbers)
    if axis is not None:
        each = {name: parts.get(name, design).controller for name in axes}
        found = PerAxisDesign(sample_time_s=found.sample_time_s, axes=each | {axis: found})
    return with_learned(design, found, told)


def _axes(design: Design) -> tuple[str, ...]:
    """The axes that have a state each."""
    from hfc_design.files.pairing import axes_of  # with JAX

    return () if design.kind.controller and not design.kind.axes else axes_of(design)


def _numbers(text: str) -> list[float]:
    """Numbers with blanks, commas, semicolons or line ends between them."""
    return [number_of(word) for word in re.split(r"[\s,;]+", text.strip())]


def _parameters(text: str, axis: str | None) -> list[float]:
    """The learnt parameters of the controller of an axis, in the order of their places."""
    found = {}
    for line in text.splitlines():
        one = PARAMETER.match(line.strip())
        if one and one["axis"] == (axis and re.sub(r"\W", "_", axis)):
            found[int(one["place"])] = number_of(one["value"])
    if not found:
        name = f"{axis}-controller" if axis else "controller"
        raise ValueError(f"has no parameter {name}.learnt-00; halcmd save param prints them")
    missing = next((k for k in range(len(found)) if k not in found), None)
    if missing is not None:
        raise ValueError(f"has no parameter learnt-{missing:02}")
    return [found[k] for k in range(len(found))]
