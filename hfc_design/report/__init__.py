"""The report of a run: one page that needs nothing else, not even a network; its pictures."""

import base64
import hashlib
import re
from collections.abc import Callable, Collection, Container, Iterable, Sequence
from importlib.resources import files
from itertools import chain, count
from typing import NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from hfc_design.pictures.files import address
from hfc_design.pictures.section import Listing
from hfc_design.pictures.units import BELOW

REPORT = "report.html"
#: Letters of the name of a file.
LONGEST = 120


class Page(NamedTuple):
    """A page, and what stands on it by names that files can have, in its order."""

    html: bytes
    figures: dict[str, Figure]
    tables: dict[str, Listing]
    of: str  # what the page is about, as captions outside of it say; "" where they say it anyway
    label: str  # the same in letters that labels may have


def rendered(
    name: str,
    /,
    of: str,
    picture: Callable[[Figure], str] = address,
    label: str = "",
    **values: object,
) -> Page:
    """The page of a template; everything that stands in the values is escaped.

    ``of`` is what it is about, ``label`` the same where captions do not need it; ``picture`` is
    how a figure becomes the address of an image.
    """
    environment = Environment(
        loader=PackageLoader("hfc_design.report"), autoescape=True, undefined=StrictUndefined
    )
    figures: dict[str, Figure] = {}
    tables: dict[str, Listing] = {}

    def drawn(figure: Figure, called: str, shaded: bool = False) -> str:
        figures[_free(called, figures)] = figure
        return _shaded(picture, figure) if shaded else picture(figure)

    def collected(
        called: str,
        caption: str,
        head: Sequence[str],
        rows: Iterable[Sequence[str]],
        best: Iterable[Collection[int]] = (),
    ) -> str:
        cells = [[*map(str, row)] for row in rows]
        listing = Listing(str(caption), [*map(str, head)], cells, [*best])
        tables[_free(called, tables)] = listing
        return ""

    environment.filters |= {"picture": drawn, "digest": digest, "capital": capital}
    environment.globals |= {"collected": collected, "inside": inside}
    html = environment.get_template(name).render(**values).encode()
    return Page(html, figures, tables, of, plain_name(label or of))


def plain_name(called: str) -> str:
    """Letters and digits of what something is called, as files and labels may have them."""
    letters = re.sub("[^a-z0-9]+", "-", called.lower()).strip("-")
    return letters[:LONGEST].rstrip("-") or "unnamed"


def _free(called: str, taken: Container[str]) -> str:
    """A name for a file: letters and digits of what it is called, with a number if need be."""
    name = plain_name(called)
    names = chain([name], (f"{name}-{k}" for k in count(2)))
    return next(one for one in names if one not in taken)


def _shaded(picture: Callable[[Figure], str], figure: Figure) -> str:
    """The same with the shades of a surface as pixels: a third of the letters."""
    axes = figure.axes[0]
    axes.set_rasterization_zorder(BELOW)
    image = picture(figure)
    axes.set_rasterization_zorder(None)
    return image


def inside(*names: str) -> Markup:
    """Files of this folder, one after the other, as they are to stand in a page."""
    texts = [(files(__name__) / name).read_text(encoding="utf-8") for name in names]
    return Markup("\n").join(map(Markup, texts))


def capital(text: str) -> str:
    """A line with its first letter as a sentence has it."""
    return text[:1].upper() + text[1:]


def digest(text: str) -> str:
    """By which a page says that a script or style of its own is the one that it means."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
