"""Files from templates; the same design gives the same bytes."""

from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError
from hfc_design.files.design import Design
from hfc_design.formats.units import facts


def rendered(template: str, design: Design, **values: Any) -> str:
    """A template of ``formats/templates`` with ``values``, ``design`` and its ``facts``.

    ``x | number`` writes a float so that it reads back bit for bit.
    """
    environment = Environment(
        loader=PackageLoader("hfc_design.formats"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # no markup, and nothing that a user wrote freely
    )
    environment.filters["number"] = lambda value: repr(float(value))
    environment.filters["hyphens"] = lambda name: name.replace("_", "-")
    return environment.get_template(template).render(design=design, facts=facts(design), **values)


def write_folder(path: Path, texts: dict[str, str]) -> None:
    """Write ``texts`` by file name into the folder ``path``.

    Raises:
        RunError: the folder cannot be written.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{path}: cannot be written: {error.strerror or error}") from None
    for name, text in texts.items():
        write_whole(path / name, text.encode())
