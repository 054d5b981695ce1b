"""Folder of a design in C: sources, README page, test vectors, and ``make check``."""

import re
from collections.abc import Sequence

from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.formats import code, saving
from hfc_design.formats.deployment import readme
from hfc_design.formats.deployment.vectors import Vectors, vectors
from hfc_design.formats.writing import Content, csv_text, head, rendered, signal_units

#: Functions of ``math.h`` that generated sources may call.
FUNCTIONS = ("exp", "tanh", "sqrt")


def with_check(
    design: Design, files: dict[str, str], same: Vectors | None = None, note: str = ""
) -> dict[str, Content]:
    """Return the C sources ``files`` with README page, test program and test vectors.

    ``same`` are the vectors if the sources do not compute the law of the design's kind, as with
    tabulated terms; default: those of the design. ``note`` is a remark for the page.
    """
    filled = values(design, files, same, note)
    page = rendered("deployment/README.md.j2", design, **filled)
    return {**files, "README.md": page, **checked(design, filled)}


def of_axes(design: Design, axes: Sequence[str]) -> dict[str, Content]:
    """Return the files beside the folders of the axes: README page, and ``make check`` for all."""
    checks = rendered("deployment/axes.mk.j2", design, axes=axes)
    return page_of_axes(design, axes) | {"Makefile": checks}


def page_of_axes(design: Design, axes: Sequence[str]) -> dict[str, Content]:
    """Return the README page that lists the folders of the axes."""
    values = {"name": code.c_name(design), "axes": axes, "about": readme.origin(design)}
    return {"README.md": rendered("deployment/axes.md.j2", design, **values)}


def checked(design: Design, template_values: Json) -> dict[str, Content]:
    """Return ``Makefile``, and the folder ``check/`` with the test program and the test vectors."""
    check = {"check.c": rendered("deployment/check.c.j2", design, **template_values)}
    check["vectors.csv"] = table(design, template_values["vectors"], template_values["note"])
    recipe = rendered("deployment/Makefile.j2", design, **template_values)
    return {"Makefile": recipe, "check": check}


def table(design: Design, vectors: Vectors, note: str = "") -> str:
    """Return the test vectors as CSV; lines that begin with # describe them."""
    unit = signal_units(design).get("command", "")
    notes = [note] if note else []
    notes += [f"tolerance in double: {vectors.tolerance.double!r} {unit}"]
    notes += [f"tolerance in float: {vectors.tolerance.single!r} {unit}, where float is 1"]
    lines = "".join(f"# {line}\n" for line in head(design, notes))
    return lines + csv_text([vectors.columns, *vectors.rows])


def values(
    design: Design, files: dict[str, str], same: Vectors | None = None, note: str = ""
) -> Json:
    """Return the values for the templates; for the arguments see ``with_check``."""
    name, test_vectors = code.c_name(design), same or vectors(design)
    text = "\n".join(files.values())
    unfit = re.search(r'#error "has to be in double: in float (.*)"', text)
    used = [x for x in FUNCTIONS if f"#define {x.upper()} {x}" in text]
    filled = readme.values(design, test_vectors) | {"name": name, "note": note}
    filled["sources"] = sorted(file for file in files if file.endswith(".c"))
    filled["headers"] = sorted(file for file in files if file.endswith(".h"))
    filled |= {"library": "#include <math.h>" in text, "whole": design.kind.law is None}
    filled["functions"] = ", ".join(f"`{x}`" for x in used)
    filled |= {"only_double": unfit[1] if unfit else "", "sizes": saving.size(design)}
    filled["inputs"] = list(code.signals(design))
    unit = signal_units(design).get("command", "")
    return filled | {"unit": "".join(x for x in unit if x not in '%"\\')}
