"""The report of a run: one page that needs nothing else, not even a network; its pictures."""

import base64
import hashlib
from collections.abc import Callable
from functools import partial
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from hfc_design.pictures.figure import address
from hfc_design.pictures.units import BELOW

REPORT = "report.html"


def rendered(name: str, /, picture: Callable[[Figure], str] = address, **values: object) -> bytes:
    """The page of a template; everything that stands in the values is escaped.

    ``picture`` is how a figure becomes the address of an image.
    """
    environment = Environment(
        loader=PackageLoader("hfc_design.report"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters["picture"] = picture
    environment.filters["shaded_picture"] = partial(_shaded, picture)
    environment.filters["digest"] = digest
    return environment.get_template(name).render(**values).encode()


def _shaded(picture: Callable[[Figure], str], figure: Figure) -> str:
    """The same with the shades of a surface as pixels: a third of the letters."""
    axes = figure.axes[0]
    axes.set_rasterization_zorder(BELOW)
    found = picture(figure)
    axes.set_rasterization_zorder(None)
    return found


def inside(*names: str) -> Markup:
    """Files of this folder, one after the other, as they are to stand in a page."""
    texts = [(files(__name__) / name).read_text(encoding="utf-8") for name in names]
    return Markup("\n").join(map(Markup, texts))


def digest(text: str) -> str:
    """By which a page says that a script or style of its own is the one that it means."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
