r"""A figure as a PGF picture, which a paper has by ``\input`` in the letters of its own.

matplotlib's canvas for this asks a TeX program how wide every text is. Here its own letters are
measured instead: no TeX need be there. Texts stand where they are anchored, so that only what lies
around them, as a legend, is as large as those letters ask for.
"""

import io
import re

from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_pgf import RendererPgf
from matplotlib.figure import Figure

from hfc_design.core.records import UserError
from hfc_design.pictures.latex import escaped

HEAD = r"""% A figure of hfc-design. In the preamble: \usepackage{pgf}
\begingroup%
\makeatletter%
\providecommand\mathdefault[1]{#1}%
\begin{pgfpicture}%
"""
TAIL = r"""\end{pgfpicture}%
\makeatother%
\endgroup%
"""


class Renderer(RendererPgf):
    """Draws what matplotlib's does; texts are escaped, and measured without TeX."""

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):  # type: ignore[no-untyped-def]
        """Draw a text; of its formulas matplotlib's own parser has read every command."""
        parts = re.split(r"(?<!\\)\$", s) if ismath else [s]
        texts = (f"${part}$" if k % 2 else escaped(part) for k, part in enumerate(parts))
        super().draw_text(gc, x, y, "".join(texts), prop, angle, ismath, mtext)

    def get_text_width_height_descent(self, s, prop, ismath):  # type: ignore[no-untyped-def]
        """Measure a text in matplotlib's letters."""
        return RendererBase.get_text_width_height_descent(self, s, prop, ismath)

    def draw_image(self, gc, x, y, im, transform=None):  # type: ignore[no-untyped-def]
        """Refuse an image, which would be a file of its own."""
        raise UserError("a figure with an image in it cannot be a pgf; take pdf")


def picture(figure: Figure) -> bytes:
    """The figure; the same figure gives the same bytes.

    Raises:
        UserError: there is an image in it.
    """
    file = io.StringIO()
    width, height = figure.get_size_inches()
    file.write(HEAD)
    file.write(
        rf"\pgfpathrectangle{{\pgfpointorigin}}{{\pgfqpoint{{{width:f}in}}{{{height:f}in}}}}%"
        "\n\\pgfusepath{use as bounding box, clip}%\n"
    )
    figure.draw(Renderer(figure, file))
    file.write(TAIL)
    return file.getvalue().encode()
