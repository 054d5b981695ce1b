"""How a page is made of its template; it needs nothing else, not even a network."""

import base64

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from hfc_design.pictures.figure import image


def rendered(name: str, /, **values: object) -> bytes:
    """The page of a template; everything that stands in the values is escaped."""
    environment = Environment(
        loader=PackageLoader("hfc_design.report"), autoescape=True, undefined=StrictUndefined
    )
    environment.filters["picture"] = _picture
    return environment.get_template(name).render(**values).encode()


def _picture(figure: Figure) -> str:
    """A figure as the address of an image, so that its names cannot clash with the page's."""
    return "data:image/svg+xml;base64," + base64.b64encode(image(figure, "svg")).decode()
