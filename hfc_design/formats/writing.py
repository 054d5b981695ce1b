"""Files from templates; the same design gives the same bytes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import (
    BaseLoader,
    ChoiceLoader,
    DictLoader,
    Environment,
    FileSystemLoader,
    StrictUndefined,
)

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError
from hfc_design.files.design import Design
from hfc_design.formats.units import facts

TEMPLATES = Path(__file__).parent / "templates"


def rendered(
    template: str, design: Design, places: Sequence[Path | dict[str, str]] = (), **values: Any
) -> str:
    """A template of ``places`` or of ``formats/templates``, with ``design`` and its ``facts``.

    ``x | number`` writes a float so that it reads back bit for bit.
    """
    environment = Environment(
        loader=ChoiceLoader([_loader(place) for place in (*places, TEMPLATES)]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # no markup, and nothing that a user wrote freely
    )
    environment.filters["number"] = lambda value: repr(float(value))
    environment.filters["hyphens"] = lambda name: name.replace("_", "-")
    return environment.get_template(template).render(design=design, facts=facts(design), **values)


def _loader(place: Path | dict[str, str]) -> BaseLoader:
    return DictLoader(place) if isinstance(place, dict) else FileSystemLoader(place)


def make_folder(path: Path) -> None:
    """Make the folder ``path``, if need be.

    Raises:
        RunError: it cannot be written.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{path}: cannot be written: {error.strerror or error}") from None


def write_folder(path: Path, texts: dict[str, str]) -> None:
    """Write ``texts`` by file name into the folder ``path``.

    Raises:
        RunError: the folder cannot be written.
    """
    make_folder(path)
    for name, text in texts.items():
        write_whole(path / name, text.encode())
