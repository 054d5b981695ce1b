"""What a search may begin with: a controller, or the name of a design that has one."""

from pydantic import ValidationInfo

from hfc_design.core.numbers import Plain
from hfc_design.core.records import UserError


def controller_named(start: Plain, info: ValidationInfo) -> Plain:
    """The controller of the design that ``start`` names; a record stays one.

    Raises:
        ValueError: there is no such design, or it is not of the kind of the settings.
    """
    if not isinstance(start, str):
        return start
    try:
        design = (info.context or {})["named_design"](start)
    except UserError as error:
        raise ValueError(error.typed) from None
    if (kind := design.controller.kind) != info.data.get("kind"):
        raise ValueError(f"is of kind {kind}, which needs controller.kind = {kind!r}")
    return design.controller.model_dump()
