"""Writers of a design for other programs: a module for each, which makes itself known."""

import importlib
import pkgutil

from hfc_design.formats.writing import Format

_MODULES = [module.name for module in pkgutil.iter_modules(__path__) if not module.ispkg]
_PARTS = (importlib.import_module(f"{__name__}.{name}") for name in _MODULES)
_FOUND = {found.name: found for part in _PARTS for found in getattr(part, "FORMATS", ())}
#: Every format by its name.
FORMATS: dict[str, Format] = dict(sorted(_FOUND.items()))
