"""The design file itself."""

from pathlib import Path

from hfc_design.core.checkpoint import write_whole
from hfc_design.files.design import Design, design_json
from hfc_design.formats.format import Format


def write(design: Design, path: Path) -> None:
    """Write ``design`` to the file ``path``."""
    write_whole(path, (design_json(design) + "\n").encode())


FORMATS = (Format("json", "the design file itself", write, whole=True),)
