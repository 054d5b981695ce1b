"""Writers of a design for other programs: one function a format, a dict of them."""

from collections.abc import Callable
from pathlib import Path

from hfc_design.export import c_source, csv_tables, json_file, linuxcnc
from hfc_design.rulebase import Design

#: Format -> (what it writes, writer). A writer takes a design and a path that does not exist.
FORMATS: dict[str, tuple[str, Callable[[Design, Path], None]]] = {
    "json": ("the design file itself", json_file.write),
    "csv": ("a folder with one labelled rule table a unit, and manifest.csv", csv_tables.write),
    "c": ("a folder with the controller in C99, adaptation and all", c_source.write),
    "linuxcnc": ("a folder with a HAL component and a simulated machine", linuxcnc.write),
}
