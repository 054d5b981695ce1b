"""FMU archive of a model: a ZIP file of C sources, a binary, a description and a README page."""

import hashlib
import io
import zipfile
from collections.abc import Mapping
from functools import partial
from html import escape
from sys import float_info
from uuid import UUID

from markdown_it import MarkdownIt

from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import axes_of
from hfc_design.formats import compiling
from hfc_design.formats.deployment import readme
from hfc_design.formats.fmu.control import commands_machine
from hfc_design.formats.fmu.description import Model, Variable, described
from hfc_design.formats.writing import rendered

#: C files of every FMU; one more file belongs to the version of FMI.
AROUND = ("model.h", "model.c", "slave.h", "slave.c", "export.h")
#: Versions of FMI; a ``compiling.Platform`` has a folder for each.
VERSIONS = "fmi2", "fmi3"
#: Markdown renderer that escapes HTML in a text.
MARKDOWN = MarkdownIt("commonmark", {"html": False}).enable("table")


def page(model: Model, design: Design) -> str:
    """Return the README page of a model, which is the same for every version of FMI."""
    whole = commands_machine(design)
    axes = axes_of(design) if whole or model.part != "controller" else ()
    several = whole or (len(axes) > 1 and not design.axis)
    values = readme.known(design, axes if several else ()) | {"model": model}
    body = MARKDOWN.render(rendered("fmu/index.md.j2", design, **values))
    return rendered("fmu/index.html.j2", design, title=escape(model.name), body=body)


def fmus(model: Model, design: Design) -> dict[str, bytes]:
    """Return an FMU for each version of FMI, by file name.

    Raises:
        UserError: a C file of the design has the name of a file that every FMU has.
        RunError: the C compiler fails.
    """
    return {f"{model.name}_{version}.fmu": _fmu(model, design, version) for version in VERSIONS}


def _fmu(model: Model, design: Design, version: str) -> bytes:
    """Return the archive; its token is a hash of description, README page and C sources."""
    documentation = page(model, design)
    sources = _sources(model, design, version, "")
    compiled = sorted(name for name in sources if name.endswith(".c"))
    describe = partial(described, model, design, compiled, version)
    texts = [describe(""), documentation, *(f"{name} {x}" for name, x in sorted(sources.items()))]
    digest = hashlib.sha256("\0".join(texts).encode()).hexdigest()
    token = f"{{{UUID(digest[:32])}}}"
    sources = _sources(model, design, version, token)
    files: dict[str, str | bytes] = {"modelDescription.xml": describe(token)}
    files["documentation/index.html"] = documentation
    files |= {f"sources/{name}": text for name, text in sorted(sources.items())}
    if version == "fmi3":  # version 2 lists the sources in its description
        build = rendered("fmu/build.xml.j2", design, name=model.name, compiled=compiled)
        files["sources/buildDescription.xml"] = build
    for where in compiling.compilers():
        place = f"binaries/{getattr(where, version)}/{model.name}{where.ending}"
        files[place] = compiling.shared_library(sources, model.name, where)
    return _archive(files)


def _sources(model: Model, design: Design, version: str, token: str) -> dict[str, str]:
    """Return file name -> text of all C files; the ``token`` is written into the code."""
    values: Json = {"token": token, "version": version, "part": model.part, **model.values}
    values["variables"] = list(map(_in_c, model.variables))
    values["at"] = {x.name: f"values[{k}]" for k, x in enumerate(model.variables)}
    names = (*AROUND, f"{version}.c")
    if taken := model.sources.keys() & set(names):
        message = f"the name {min(taken)} is used inside an FMU"
        raise UserError(f"design {design.name}: {message}; give the design another name")
    return model.sources | {name: rendered(f"fmu/{name}.j2", design, **values) for name in names}


def _in_c(variable: Variable) -> Json:
    """Return a variable for C templates; with finite bounds the code refuses infinite values."""
    settable = "fixed" if variable.fixed else "tunable"
    causality = settable if variable.causality == "parameter" else variable.causality
    largest = float_info.max
    bounds = max(variable.lowest, -largest), min(variable.highest, largest)
    return variable._asdict() | {"causality": causality, "lowest": bounds[0], "highest": bounds[1]}


def _archive(files: Mapping[str, str | bytes]) -> bytes:
    """Return a ZIP archive of the files; equal files give equal bytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content)
    return buffer.getvalue()
