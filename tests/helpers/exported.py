"""What a format writes of a design, as texts; test vectors of one controller are made once."""

from pathlib import Path
from tempfile import TemporaryDirectory
from unittest import mock

import numpy as np

from hfc_design.core.records import UserError
from hfc_design.files.loop_setup import axes_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import FORMATS
from hfc_design.formats.deployment import folder

_VECTORS = {}
_fresh = folder.vectors


def texts(design, to):
    """Path within the folder -> text; of a format of one file under "out". Refused is nothing."""
    with TemporaryDirectory() as top, mock.patch.object(folder, "vectors", _remembered):
        out = Path(top) / "out"
        try:
            FORMATS[to].write(design, out)
        except UserError:
            assert not out.exists()
            raise
        if out.is_file():
            return {"out": out.read_text()}
        found = (path for path in out.rglob("*") if path.is_file())
        return {str(path.relative_to(out)): path.read_text() for path in found}


def _remembered(design, law=None):
    """The vectors, which hang on what a controller is and is held to, and not on its machine."""
    axes = (design.axis,) if design.kind.law else axes_of(design)
    own = design.model_dump_json(include={"controller", "limits"}), axes, law
    if own not in _VECTORS:
        _VECTORS[own] = _fresh(design, law)
    return _VECTORS[own]


def with_controller(design, **changes):
    return design.model_copy(update={"controller": design.controller.model_copy(update=changes)})


def with_scenario(design, name, *changes):
    """The same, scored on a scenario."""
    scenario = load_scenario(name, changes).model_dump(mode="json", exclude_none=True)
    return design.model_copy(update={"provenance": {"scenario": scenario}})


def table(text):
    """(n, columns) numbers of a file whose columns are apart by spaces."""
    return np.array([line.split() for line in text.splitlines()], float)
