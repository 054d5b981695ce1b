"""The report of a run: a self-contained page that works without a network, and its pictures."""

import base64
import hashlib
import re
from collections.abc import Callable, Container
from importlib.resources import files
from itertools import chain, count
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from hfc_design.core.tables import Table
from hfc_design.plotting.files import address
from hfc_design.plotting.units import BELOW

REPORT = "report.html"
#: Largest number of letters in the name of a file.
LONGEST = 120


class Page(NamedTuple):
    """A page, with its figures and tables by valid file names, in the order of the page."""

    html: bytes
    figures: dict[str, Figure]
    tables: dict[str, Table]
    of: str  # subject of the page, for captions outside it; "" if captions name the subject anyway
    label: str  # the subject in letters and digits, for labels in LaTeX


def rendered(
    name: str,
    /,
    of: str,
    picture: Callable[[Figure], str] = address,
    label: str = "",
    **values: object,
) -> Page:
    """Return the page that the template ``name`` makes from ``values``, which are escaped.

    ``of`` is the subject of the page, ``label`` a short form of the subject for labels; ``picture``
    converts a figure to the address of an image.
    """
    environment = Environment(
        loader=PackageLoader("hfc_design.report"), autoescape=True, undefined=StrictUndefined
    )
    figures: dict[str, Figure] = {}
    tables: dict[str, Table] = {}

    def drawn(figure: Figure, called: str, shaded: bool = False) -> str:
        figures[_free(called, figures)] = figure
        return _shaded(picture, figure) if shaded else picture(figure)

    def collected(table: Table, called: str) -> Table:
        texts = table._replace(rows=[[*map(str, row)] for row in table.rows])  # if not text
        tables[_free(called, tables)] = texts
        return texts

    environment.filters |= {"picture": drawn, "digest": digest, "capital": capital}
    environment.filters["collected"] = collected
    environment.globals["inside"] = inside
    html = environment.get_template(name).render(**values).encode()
    return Page(html, figures, tables, of, plain_name(label or of))


def plain_name(called: str) -> str:
    """Return the letters and digits of a title with hyphens, valid in file names and labels."""
    letters = re.sub("[^a-z0-9]+", "-", called.lower()).strip("-")
    return letters[:LONGEST].rstrip("-") or "unnamed"


def _free(called: str, taken: Container[str]) -> str:
    """Return an unused file name from a title: ``plain_name``, with a number if necessary."""
    name = plain_name(called)
    names = chain([name], (f"{name}-{k}" for k in count(2)))
    return next(one for one in names if one not in taken)


def _shaded(picture: Callable[[Figure], str], figure: Figure) -> str:
    """Return ``picture(figure)`` with the shades of a surface as pixels, a third as long."""
    axes = figure.axes[0]
    axes.set_rasterization_zorder(BELOW)
    image = picture(figure)
    axes.set_rasterization_zorder(None)
    return image


def inside(*names: str) -> Markup:
    """Return files of this folder, concatenated for inclusion in a page."""
    texts = [(files(__name__) / name).read_text(encoding="utf-8") for name in names]
    return Markup("\n").join(map(Markup, texts))


def capital(text: str) -> str:
    """Return a line with a capital first letter."""
    return text[:1].upper() + text[1:]


def digest(text: str) -> str:
    """Return the digest by which a page identifies its own scripts and styles."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
