"""Writers of a design for other programs: a module for each, which makes itself known."""

import importlib
import pkgutil

from hfc_design.formats.format import Format

_MODULES = sorted(module.name for module in pkgutil.iter_modules(__path__) if not module.ispkg)
#: Every format by its name.
FORMATS: dict[str, Format] = {
    found.name: found
    for name in _MODULES
    for found in getattr(importlib.import_module(f"{__name__}.{name}"), "FORMATS", ())
}
