"""On how many machines a search tries its designs, and how far they are from the nominal one."""

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
#: What has a tolerance beside the parameters of a plant: around every drive, in these units, and
#: shares of all friction while it sticks and while it moves.
AROUND = {
    "load": "load",  # constant, either way
    "delay_samples": "samples",
    "lag_s": "s",
    "noise": "1",  # of a factor on it
    "backlash": "error",  # up to so much, before the encoder that is fed back
    "friction_at_rest": "1",
    "friction_moving": "1",
}
#: Parameters of friction, by their names, which all plants are built of.
AT_REST, MOVING = re.compile("static|stiction|break_?away"), re.compile("coulomb|viscous|friction")


def friction_of(drive: Drive, at_rest: bool = True, moving: bool = True) -> list[str]:
    """The parameters of a drive that are friction, of any plant by their names."""
    names = []
    for name in drive.parameters._fields:
        sticks = AT_REST.search(name) is not None
        if (sticks and at_rest) or (not sticks and moving and MOVING.search(name)):
            names.append(name)
    return [name for name in names if name not in drive.exact]


def unknown_parameter(settings: PlantSettings, names: Iterable[str]) -> str | None:
    """The first of ``names`` that is no parameter of a machine, and what there is; None: none."""
    known = dict.fromkeys(name for parameters in settings.values() for name in parameters._fields)
    for name in names:
        if name not in known and name not in AROUND:
            return f"{name}: no parameter of {settings.machine.name}; {one_of(name, known)}"
    return None


class RobustSettings(Record):
    """Machines within tolerances, drawn once a run from its seed, the same for every candidate."""

    spread: Share = 0.2  # of every parameter, either way, as a share of it [1]
    #: spread of single parameters, by their names, as a share; and of what stands around every
    #: drive: load [load], delay_samples, lag_s [s], noise [1], backlash [error] of a plant without
    #: a parameter of that name, friction_at_rest and friction_moving [1]
    tolerances: dict[str, Annotated[float, Field(gt=0, allow_inf_nan=False)]] = {}
    #: how machines are drawn within the spread
    sample: Literal["latin-hypercube", "uniform"] = "latin-hypercube"
    keep: Keep = "mean"  # what of all machines a design is ranked by
    quantile: Share = 0.1  # that keep = 'quantile' keeps [1]
    #: share of the machines that may break a constraint in the end [1]
    forgiven: Annotated[float, Field(ge=0, lt=1)] = 0.005
    #: factor of the search's spread beyond these [1]
    margin: Annotated[float, Field(ge=1, le=2)] = 1.1
    #: factor by which a search allows less than the constraints where there is no stress [1]
    tighter: Annotated[float, Field(ge=1, le=10)] = 3.0
    first: Count = 24  # machines for every candidate, the nominal one among them
    machines: Count = 24  # for those that survive these
    elite: Count = 24  # for the best of them
    final: Count = 512  # for the choice in the end
    unseen: Count = 1000  # other ones, that the result is judged on

    @model_validator(mode="after")
    def _more_and_more(self) -> "RobustSettings":
        if not self.first <= self.machines <= self.elite <= self.final:
            raise ValueError("first <= machines <= elite <= final does not hold")
        absolute = ("load", "delay_samples", "lag_s", "backlash")
        shares = {key: x for key, x in self.tolerances.items() if key not in absolute}
        for key, spread in {"spread": self.spread, **shares}.items():
            if self.margin * spread >= 1.0:
                name = key if key == "spread" else f"tolerances.{key}"
                raise ValueError(
                    f"{name} = {spread:g}: times margin = {self.margin:g} it has to stay below 1"
                )
        return self
