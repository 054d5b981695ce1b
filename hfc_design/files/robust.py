"""Machines of a search: how many it simulates, and how far they differ from the nominal one."""

import re
from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import Field, model_validator

from hfc_design.core.records import Record
from hfc_design.core.wording import one_of
from hfc_design.files.machine import PlantSettings
from hfc_design.objectives.verdict import Keep
from plants import Drive

Share = Annotated[float, Field(gt=0, lt=1)]
Count = Annotated[int, Field(ge=1, le=100_000)]
#: Quantities with a tolerance other than the parameters of a plant, with their units: effects
#: around every drive, and factors on all friction, at rest and in motion.
AROUND = {
    "load": "load",  # constant, in both directions
    "delay_samples": "samples",
    "lag_s": "s",
    "noise": "1",  # tolerance of a factor on the noise
    "backlash": "error",  # largest backlash, before the encoder that is fed back
    "friction_at_rest": "1",
    "friction_moving": "1",
}
#: Words in the names of parameters of friction, in all plants.
AT_REST, MOVING = re.compile("static|stiction|break_?away"), re.compile("coulomb|viscous|friction")


def friction_of(drive: Drive, at_rest: bool = True, moving: bool = True) -> list[str]:
    """Return the parameters of a drive that their names say to be friction, without exact ones."""
    names = []
    for name in drive.parameters._fields:
        sticks = AT_REST.search(name) is not None
        if (sticks and at_rest) or (not sticks and moving and MOVING.search(name)):
            names.append(name)
    return [name for name in names if name not in drive.exact]


def unknown_parameter(settings: PlantSettings, names: Iterable[str]) -> str | None:
    """Return a line on the first of ``names`` that the machine does not have; None: it has all."""
    known = dict.fromkeys(name for parameters in settings.values() for name in parameters._fields)
    for name in names:
        if name not in known and name not in AROUND:
            return f"{name}: unknown parameter of {settings.machine.name}; {one_of(name, known)}"
    return None


class RobustSettings(Record):
    """Machines within tolerances, drawn once per run from its seed: the same for all candidates."""

    spread: Share = 0.2  # relative spread of every parameter, in both directions [1]
    #: relative spread of single parameters, by name [1]; also of the surroundings of every drive:
    #: load [load], delay_samples, lag_s [s], noise [1], backlash [error] of a plant without a
    #: parameter of that name, friction_at_rest and friction_moving
    tolerances: dict[str, Annotated[float, Field(gt=0, allow_inf_nan=False)]] = {}
    #: sampling of the machines within the spread
    sample: Literal["latin-hypercube", "uniform"] = "latin-hypercube"
    keep: Keep = "mean"  # statistic over all machines by which designs are ranked
    quantile: Share = 0.1  # quantile for keep = 'quantile' [1]
    #: share of the machines that may violate a constraint at the end [1]
    forgiven: Annotated[float, Field(ge=0, lt=1)] = 0.005
    #: factor on the spread during the search [1]
    margin: Annotated[float, Field(ge=1, le=2)] = 1.1
    #: factor by which the search tightens the constraints where there is no stress [1]
    tighter: Annotated[float, Field(ge=1, le=10)] = 3.0
    first: Count = 24  # machines for every candidate, including the nominal one
    machines: Count = 24  # machines for candidates that pass the first ones
    elite: Count = 24  # machines for the best candidates
    final: Count = 512  # machines for the final choice
    unseen: Count = 1000  # unseen machines on which the result is judged

    @model_validator(mode="after")
    def _more_and_more(self) -> "RobustSettings":
        if not self.first <= self.machines <= self.elite <= self.final:
            raise ValueError("must satisfy first <= machines <= elite <= final")
        absolute = ("load", "delay_samples", "lag_s", "backlash")
        shares = {key: x for key, x in self.tolerances.items() if key not in absolute}
        for key, spread in {"spread": self.spread, **shares}.items():
            if self.margin * spread >= 1.0:
                name = key if key == "spread" else f"tolerances.{key}"
                raise ValueError(
                    f"{name} = {spread:g}: must be less than {1.0 / self.margin:.3g} (1 / margin); "
                    "0.05 is 5 %"
                )
        return self
