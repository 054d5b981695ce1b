"""On how many machines a search tries its designs, and how far they are from the nominal one."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from hfc_design.core.records import Record
from hfc_design.objectives.verdict import Keep

Share = Annotated[float, Field(gt=0, lt=1)]
Count = Annotated[int, Field(ge=1, le=100_000)]


class RobustSettings(Record):
    """Machines within tolerances, drawn once a run from its seed, the same for every candidate."""

    spread: Share = 0.2  # of every parameter, either way, as a share of it
    tolerances: dict[str, Share] = {}  # of single parameters
    sample: Literal["latin-hypercube", "uniform"] = "latin-hypercube"
    keep: Keep = "mean"
    quantile: Share = 0.1  # that ``keep = "quantile"`` keeps
    forgiven: Annotated[float, Field(ge=0, lt=1)] = 0.005  # share that may break a constraint
    margin: Annotated[float, Field(ge=1, le=2)] = 1.1  # of the search's spread beyond these
    tighter: Annotated[float, Field(ge=1, le=10)] = 2.0  # factor by which a search allows less
    first: Count = 24  # machines for every candidate, the nominal one among them
    machines: Count = 24  # for those that survive these
    elite: Count = 24  # for the best of them
    final: Count = 256  # for the choice in the end
    unseen: Count = 1000  # other ones, that the result is judged on

    @model_validator(mode="after")
    def _more_and_more(self) -> "RobustSettings":
        if not self.first <= self.machines <= self.elite <= self.final:
            raise ValueError("first <= machines <= elite <= final does not hold")
        return self
