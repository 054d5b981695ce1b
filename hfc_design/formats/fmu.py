"""Functional mock-up units: a controller as a co-simulation of FMI 2.0 and of FMI 3.0.

An FMU is a ZIP archive of C sources, their binary and ``modelDescription.xml``. What is computed is
the C code of ``--to c``, so there is one control law.
"""

import hashlib
import io
import zipfile
from collections.abc import Mapping
from math import inf
from typing import NamedTuple

from hfc_design.controllers.controller import units_of
from hfc_design.controllers.rules import identifier
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.files.pairing import axes_of
from hfc_design.formats import code, compiling, machine_code
from hfc_design.formats.fmu_description import TIME, Described, Variable
from hfc_design.formats.writing import (
    Content,
    Format,
    comment,
    rendered,
    signal_meanings,
    signal_units,
)

#: What stays when a sample is faulty.
FAULTY = "the commands are not a number, and the next sample goes on as if this one had not been"
#: Names of the path that a controller of a machine sees: tangent, curvature, contour error.
PATH = ("path.tangent_x", "path.tangent_y", "path.curvature", "path.contour_error")


class Model(NamedTuple):
    """What an FMU computes."""

    name: str  # an identifier
    what: str
    every: float  # sample time [s]
    variables: list[Variable]  # the first is the time
    sources: dict[str, str]  # C of what is inside, by file
    body: str  # template with ``model_begin`` and ``model_step``
    values: Json  # what that reads


def controller(design: Design) -> Content:
    """A folder with an FMU for each version of FMI.

    Raises:
        UserError: as ``machine_code.sources``.
        RunError: the C compiler that is there fails.
    """
    return fmus(_controller(design), design)


def fmus(model: Model, design: Design) -> Content:
    """A folder with an FMU of a model for each version of FMI."""
    return {f"{model.name}_{version}.fmu": _fmu(model, design, version) for version in VERSIONS}


def _controller(design: Design) -> Model:
    """The controller of an axis, or that of a whole machine."""
    whole = design.kind.controller is not None and design.kind.axes is None
    read, told = code.signals(design), signal_meanings(design)
    axes = [f"{identifier(axis)}." for axis in axes_of(design)] if whole else [""]
    unit = signal_units(design).get("command", "")
    inputs = [[f"{axis}{name}" for name in read] for axis in axes]
    variables = [TIME]
    for axis in axes:
        for name, own in read.items():
            variables.append(Variable(axis + name, "input", own, told.get(name, name)))
    path = machine_code.sees_path(design) if whole else False
    if path:
        variables += _path_variables(design)
    meaning = told.get("command", "what the drive is to do")
    outputs = [f"{axis}command" for axis in axes]
    variables += [Variable(name, "output", unit, meaning, discrete=True) for name in outputs]
    name = code.c_name(design)
    values = {"inputs": inputs, "outputs": outputs, "whole": whole, "path": PATH if path else ()}
    values |= {"controller": name, "state": [f"{name}_state controller"], "faulty": FAULTY}
    what = f"{design.controller.kind} controller {design.name} for the plant {design.plant.name}"
    every = design.controller.sample_time_s
    sources = machine_code.sources(design)
    values["headers"] = [f"{name}.h"]
    return Model(name, what, every, variables, sources, "fmu/controller.c.j2", values)


def _path_variables(design: Design) -> list[Variable]:
    """What a controller sees of the path."""
    unit = units_of(signal_units(design) or {"error": "", "error_rate": ""})["error"]
    return [
        Variable(PATH[0], "input", "1", "along X: unit vector along the path", 1.0),
        Variable(PATH[1], "input", "1", "along Y: unit vector along the path"),
        Variable(PATH[2], "input", f"1/{unit}", "curvature of the path, positive to the left"),
        Variable(PATH[3], "input", unit, "of the measured position, positive to the left"),
    ]


#: Version -> folder of its Linux binary.
VERSIONS = {"fmi2": "linux64", "fmi3": "x86_64-linux"}


def _fmu(model: Model, design: Design, version: str) -> bytes:
    """The archive; its token is a hash of all that is in it but the binary."""
    sources = _sources(model, design, version, "")
    compiled = sorted(name for name in sources if name.endswith(".c"))
    told = Described(model.name, model.what, model.every, model.variables, compiled)
    describe = getattr(told, version)
    whole = "\0".join([describe(""), *(f"{name}\0{sources[name]}" for name in sorted(sources))])
    digest = hashlib.sha256(whole.encode()).hexdigest()
    token = "{" + "-".join(digest[a:b] for a, b in ((0, 8), (8, 12), (12, 16), (16, 20), (20, 32)))
    token += "}"
    sources = _sources(model, design, version, token)
    files: dict[str, str | bytes] = {"modelDescription.xml": describe(token)}
    files |= {f"sources/{name}": text for name, text in sources.items()}
    if version == "fmi3":
        files["sources/buildDescription.xml"] = told.build()
    if binary := compiling.shared_library(sources, model.name):
        files[f"binaries/{VERSIONS[version]}/{model.name}.so"] = binary
    return _archive(files)


def _sources(model: Model, design: Design, version: str, token: str) -> dict[str, str]:
    """Every C file, the token in it."""
    causalities = {"independent": "INDEPENDENT", "input": "INPUT", "output": "OUTPUT"}
    variables = [
        variable._asdict()
        | {
            "c_causality": causalities.get(
                variable.causality, "FIXED" if variable.fixed else "TUNABLE"
            ),
            "c_lowest": _bound(variable.lowest),
            "c_highest": _bound(variable.highest),
        }
        for variable in model.variables
    ]
    values = {
        "token": token,
        "variables": variables,
        "at": {x.name: f"values[{k}]" for k, x in enumerate(model.variables)},
        "body": model.body,
        "version": version,
        **model.values,
        "every": model.every,
    }
    names = ("model.h", "model.c", "slave.h", "slave.c", "export.h", f"{version}.c")
    own = {name: rendered(f"fmu/{name}.j2", design, **values) for name in names}
    return {**model.sources, **own}


def _bound(value: float) -> str:
    """A bound of a finite number as C."""
    largest = 1.7976931348623157e308
    return repr(max(-largest, min(value, largest))) if abs(value) == inf else repr(value)


def _archive(files: Mapping[str, str | bytes]) -> bytes:
    """A ZIP archive that is the same each time."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return buffer.getvalue()


FORMATS = (
    Format(
        "fmu",
        "a folder with the controller as co-simulation FMUs of FMI 2.0 and 3.0",
        controller,
        note=compiling.note,
    ),
)
