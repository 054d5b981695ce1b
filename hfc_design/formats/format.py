"""What a format is; a module beside this one that holds ``FORMATS`` makes its own known."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from hfc_design.core.checkpoint import write_whole
from hfc_design.files.design import Design, design_json
from hfc_design.formats.writing import make_folder


class Format(NamedTuple):
    """A way to write a design for another program."""

    name: str
    text: str  # what it writes
    #: Takes a design, or the part of one axis, and a path that does not exist. UserError: it is
    #: not for this kind, or a name cannot be there; RunError: the path cannot be written.
    part: Callable[[Design, Path], None]
    suffix: str = ""  # of a part that is a file
    whole: bool = False  # it can hold several axes

    def write(self, design: Design, path: Path) -> None:
        """Write ``design``; where its axes differ, a folder with a part for each.

        Raises:
            UserError: the format cannot hold this kind of controller.
            RunError: ``path`` cannot be written.
        """
        parts = {"": design} if self.whole else design.by_axis()
        if len(parts) == 1:
            self.part(next(iter(parts.values())), path)
            return
        make_folder(path)
        for axis, part in parts.items():
            self.part(part, path / f"{axis}{self.suffix}")


def _write_json(design: Design, path: Path) -> None:
    write_whole(path, (design_json(design) + "\n").encode())


FORMATS = (Format("json", "the design file itself", _write_json, whole=True),)
