"""Everything that a log tells of a machine."""

from typing import NamedTuple

from hfc_design.core.numbers import Json
from hfc_design.core.shown import line, table
from hfc_design.core.texts import toml_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify import words
from hfc_design.identify.advice import Advice
from hfc_design.identify.aim import scenario_text
from hfc_design.identify.asking import Task
from hfc_design.identify.certainty import Certainty
from hfc_design.identify.checks import Check, how_of
from hfc_design.identify.free import Free
from hfc_design.identify.kept import GIVEN
from hfc_design.identify.profile import Profile
from hfc_design.identify.recording import Recording
from hfc_design.identify.response import Response
from hfc_design.identify.search import Found


class Identified(NamedTuple):
    """Everything that a log tells."""

    log: str  # its name
    task: Task
    found: Found
    known: Certainty
    states: tuple[str, ...]  # of each parameter, see ``Kept``
    profiles: tuple[Profile, ...]
    checks: tuple[Check, ...]
    advice: Advice | None
    response: Response | None
    told: Recording
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        told: dict[str, object] = {"log": self.log, "plant": self.free.drive.name}
        told |= zip(self.free.names, map(float, self.known.value), strict=True)
        return line("Identified", told)

    def _repr_html_(self) -> str:
        rows: dict[str, object] = {}
        for name, unit, _, value, low, high, state in words.parameter_rows(self):
            how = f"{low} to {high}" if state in ("yes", GIVEN) else state
            rows[f"{name} [{unit or 1}]"] = f"{value} ({how})"
        for log, how, before, after in words.check_rows(self):
            rows[f"{log}, {how}"] = f"{after} off (rms), {before} before"
        return table(f"{self.free.drive.name} by {self.log}", rows)

    def numbers(self) -> Json:
        """What ``identified.json`` holds: each parameter with its interval, what is left."""
        return words.numbers(self)

    def for_design(self) -> Scenario:
        """The scenario for a search: the machine as it was found, within its tolerances.

        Raises:
            UserError: it is no scenario with these parameters.
        """
        return load_scenario(toml_of(scenario_text(self)))

    @property
    def scenario(self) -> Scenario:
        """With the machine that the fit began with."""
        return self.task.scenario

    @property
    def axis(self) -> int:
        """Which one of the machine."""
        return self.task.axis

    @property
    def free(self) -> Free:
        """The parameters that were looked for."""
        return self.found.fit.free

    @property
    def how(self) -> str:
        """How the log was replayed."""
        return how_of(self.found)

    @property
    def position_unit(self) -> str:
        """Of the residual."""
        return self.free.drive.units["error"]
