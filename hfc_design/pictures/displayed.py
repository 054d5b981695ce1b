"""A figure that a notebook shows by itself."""

from matplotlib.figure import Figure

from hfc_design.pictures.files import small_svg


class Displayed(Figure):
    """As the last line of a cell it is drawn below it, as a small SVG."""

    def _repr_svg_(self) -> str:
        return small_svg(self)
