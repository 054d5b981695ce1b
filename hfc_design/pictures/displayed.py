"""A figure that a notebook shows by itself."""

import base64
from typing import Any

from matplotlib.figure import Figure

from hfc_design.pictures.files import image, small_svg

#: Letters of an SVG above which a picture in points may be the smaller one, and these per inch.
LARGE, FINE = 50_000, 110.0


class Displayed(Figure):
    """As the last line of a cell it is drawn below it, in few bytes: SVG, or else PNG."""

    def _repr_mimebundle_(self, **asked: Any) -> tuple[dict[str, str], dict[str, Any]]:
        svg = small_svg(self)
        if len(svg) > LARGE:
            png = base64.b64encode(image(self, "png", FINE)).decode()
            if len(png) < len(svg):
                width = {"width": round(self.get_figwidth() * self.get_dpi())}
                return {"image/png": png, "text/plain": repr(self)}, {"image/png": width}
        return {"image/svg+xml": svg, "text/plain": repr(self)}, {}
