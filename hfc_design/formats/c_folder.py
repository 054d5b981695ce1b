"""Export format of ``--to c``: a design in C99 with a README page and a test program."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design.files.design import Design
from hfc_design.formats import code
from hfc_design.formats.deployment.folder import of_axes, with_check
from hfc_design.formats.deployment.vectors import Vectors, deviation, vectors
from hfc_design.formats.writing import Content, Format, signal_units

#: Relative deviation of tabulated terms from which the motion of a loop may change noticeably: with
#: it, the settled error of Lin & Lee's Table I on the ramp of their paper is 2 % larger.
COARSE = 0.01


def folder(design: Design) -> Content:
    """Return sources, README page, vectors and ``make check``; UserError: see ``code.sources``."""
    return with_check(design, code.sources(design))


class Tabulated(NamedTuple):
    """Deviation of a controller with tabulated terms from the exact one."""

    of: str  # what deviates: "command", or "factor of the scheduled law"
    unit: str  # of ``deviation``; "" if unknown
    deviation: float  # largest deviation that a search over the inputs found
    share: float  # deviation / largest output of the rules
    command_unit: str
    off: float  # largest difference of the commands on the test vectors
    off_share: float  # off / limit of the command; without a limit, off / largest command there

    @property
    def coarse(self) -> bool:
        """True if the deviation is so large that the loop may behave differently."""
        return max(self.share, self.off_share) >= COARSE

    @property
    def lines(self) -> list[str]:
        """Lines of text that describe the deviation."""
        size = f"{self.deviation:.2g} {self.unit}".rstrip()
        first = f"{size}, {100 * self.share:.2g} % of the largest output of the rules"
        off = f"{self.off:.2g} {self.command_unit}".rstrip()
        second = f"{off} at most, {100 * self.off_share:.2g} % of the largest"
        return [
            f"largest deviation from the exact {self.of}: {first}",
            f"on the test vectors commands are off by {second}",
        ]


def write_lookup(
    design: Design,
    path: Path,
    points: int,
    connect: Callable[[Design], Design] = lambda design: design,
) -> dict[str, Tabulated]:
    """Write the C folder with a table of degrees at ``points`` values in place of ``exp``.

    Returns:
        Axis -> its deviation; the only key is "" if all axes share one code.

    Raises:
        UserError: the controller has no terms with an exponential; or in the cases of ``folder``.
        RunError: the folder ``path`` cannot be written.
    """
    tables = {}

    def content(part: Design) -> Content:
        files, tables[part.axis], vectors = _tabulated(part, points)
        accuracy = "; ".join(tables[part.axis].lines)
        return with_check(
            part, files, vectors, f"Its terms are tabulated at {points} values: {accuracy}."
        )

    Format("c", C, content, companions=of_axes).write(design, path, connect)
    return tables


def _tabulated(design: Design, points: int) -> tuple[dict[str, str], Tabulated, Vectors]:
    files, values = code.tabulated(design, points)
    limit = design.limits.of(design.axis).command
    same = vectors(design, values["law"](limit))
    units, of, far = signal_units(design), values["deviates"], values["deviation"]
    off, largest = deviation(design, same), limit or float(np.abs(same.commands).max())
    share, off_share = (
        part / whole if whole else 0.0 for part, whole in ((far, values["largest"]), (off, largest))
    )
    unit, command_unit = units.get(of, ""), units.get("command", "")
    return files, Tabulated(of, unit, far, share, command_unit, off, off_share), same


C = "a folder with the controller in C99, including adaptation, a README and make check"
FORMATS = (Format("c", C, folder, companions=of_axes, connects=True),)
