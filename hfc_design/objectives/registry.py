"""Every objective by its name: the files here, and what users add."""

from typing import Annotated

from pydantic import SerializeAsAny

from hfc_design import objectives
from hfc_design.core.plugins import Group, chosen, found_in, lacking
from hfc_design.objectives.objective import Objective, ObjectiveSettings

OBJECTIVES: Group[Objective] = Group(
    "fitness",
    Objective,
    "hfc_design.fitness",
    found_in(objectives, "OBJECTIVE"),
    fault=lambda x: lacking(x, ("initial", "update", "score", "fault"), ObjectiveSettings),
)
#: The ``[fitness]`` of a scenario.
FitnessSettings = Annotated[
    SerializeAsAny[ObjectiveSettings], chosen(OBJECTIVES, "settings", default="lin-lee")
]


def objective_of(settings: ObjectiveSettings) -> Objective:
    """The objective with these settings."""
    found = OBJECTIVES.get(settings.kind)
    return found.make(settings) if found.make else found
