"""Records of the self-organising fuzzy controller in a design file. Never imports JAX."""

from typing import Annotated, Literal, Self

from pydantic import Field

from hfc_design.controllers.controller import AxisLaw
from hfc_design.controllers.gains import FEEDS, genome_of_gains, settings_of
from hfc_design.controllers.kind import CHANGES, ControllerRecord, later
from hfc_design.controllers.soc.law import HIGHEST, SETS, SocGains, SocMemory, soc
from hfc_design.core.numbers import Json
from hfc_design.core.records import Finite, NotNegative, Positive, Record

Row = Annotated[tuple[Finite, ...], Field(min_length=SETS, max_length=SETS)]
Table = Annotated[tuple[Row, ...], Field(min_length=SETS, max_length=SETS)]
#: Table of an untrained controller.
EMPTY: Table = ((0.0,) * SETS,) * SETS

#: Search ranges for a milling table with errors in mm and commands in V.
RANGES = SocGains((2.0, 100.0), (5.0, 300.0), (0.2, 20.0), (0.02, 0.9), (0.1, 0.9))


class AdaptationRecord(Record):
    """Correction of the rules, see ``SocGains``."""

    gamma: NotNegative  # share of the error that a correction removes [1]
    #: weight of the error's change in a correction; the error itself has 1 - xi [1]
    xi: Annotated[float, Field(ge=0, le=1)]


class SocDesign(ControllerRecord):
    """Design of kind ``soc``.

    Its gains are for errors counted in ``error_unit`` and commands in ``command_unit``. Published
    gains, for example, count steps of a linear scale and of a converter.
    """

    kind: Literal["soc"] = "soc"
    summary = "fuzzy, learns its 11 x 11 rules from empty tables (Huang & Shy)"
    settings = settings_of(RANGES, FEEDS)
    genome = genome_of_gains
    no_rules = (
        "it learns its rules in the loop, which that format cannot represent; use c, "
        "fmu or linuxcnc"
    )
    steps_of_adaptation = ("gamma",)
    explain = later(".", "EXPLAIN")
    pictures = later(".section", "pictures")
    sections = later(".section", "sections")
    ge: Positive  # sets per ``error_unit`` of the error [1]
    gc: Positive  # sets per ``error_unit`` of the error's change in a sample [1]
    gu: Positive  # command for a rule of 1, counted in ``command_unit`` [1]
    adaptation: AdaptationRecord  # learning of the table
    error_unit: Positive = 1.0  # unit in which gains count the error, in the drive's unit [error]
    command_unit: Positive = 1.0  # unit in which gains count the command [command]
    #: initial table [1]; rows: error, columns: its change, both from -5 to 5
    table: Table = EMPTY

    def law_gains(self) -> SocGains:
        """Return the gains on errors and commands in the drive's units."""
        ge, gc = self.ge / self.error_unit, self.gc / self.error_unit
        return SocGains(ge, gc, self.gu * self.command_unit, *dict(self.adaptation).values())

    def input_range(self, limit: float | None) -> dict[str, float]:
        """Return the centres of the outermost sets of both inputs."""
        gains = self.law_gains()
        return {"error": HIGHEST / gains.ge, "error_change": HIGHEST / gains.gc}

    def law(self, limit: float | None) -> AxisLaw:
        """Return the law of one axis."""
        return soc(self.table, self.sample_time_s, limit)

    def reads(self) -> list[str]:
        """Return the signals that the controller reads; it computes the change of the error."""
        return ["error"]

    def connecting(self) -> list[str]:
        """Return a note that the controller computes the change of the error itself."""
        return [CHANGES]

    @staticmethod
    def of_gains(gains: dict[str, float]) -> Json:
        """Return the keys of a controller with these gains; its table is left out, thus 0."""
        adaptation = {key: gains[key] for key in AdaptationRecord.model_fields}
        return {**{key: gains[key] for key in ("ge", "gc", "gu")}, "adaptation": adaptation}

    def adapted(self, memory: SocMemory) -> Self:
        """Return the design with the learned table."""
        return self.model_copy(update={"table": tuple(map(tuple, memory.rules))})
