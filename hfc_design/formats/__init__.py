"""Formats that export a design for other programs, collected from the modules of this folder."""

import importlib
import pkgutil
from collections.abc import Callable
from functools import partial
from typing import Any

from hfc_design.core.records import UserError, option
from hfc_design.files.design import Design
from hfc_design.formats.connection import connect
from hfc_design.formats.writing import Format

_MODULES = [module.name for module in pkgutil.iter_modules(__path__) if module.name != "reading"]
_PARTS = (importlib.import_module(f"{__name__}.{name}") for name in _MODULES)
_FOUND = {one.name: one for part in _PARTS for one in getattr(part, "FORMATS", ())}
#: All export formats by name.
FORMATS: dict[str, Format] = dict(sorted(_FOUND.items()))


def connecting(form: Format, bare: bool) -> Callable[[Design], Design]:
    """Return the function that makes exported code read the sensors of a design's scenario.

    This function returns designs unchanged if ``bare`` is true or ``form.connects`` is false.
    """
    return connect if form.connects and not bare else lambda design: design


def with_data(form: Format, **given: Any) -> Format:
    """Return a format of parameters with ``motor`` and ``old``; UserError: it is another format."""
    for name in (name for name, x in given.items() if x and not form.parameters):
        known = ", ".join(one.name for one in FORMATS.values() if one.parameters)
        raise UserError(f"{option(name)}: is for the parameters of a control: {known}")
    return form._replace(content=partial(form.content, **given)) if form.parameters else form


def check_score(design: Design, anyway: bool) -> None:
    """Check a design before its export; UserError: it diverged when scored, and not ``anyway``."""
    if design.failed and not anyway:
        where = design.score.get("scenario", "its scenario")
        fault = f"diverged on {where} when it was scored"
        advice = f"to export it nevertheless add {option('anyway', True)}"
        raise UserError(f"design {design.name}: {fault}; {advice}")
