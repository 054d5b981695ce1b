"""The genome of a search, and conversion of its individuals to designs."""

from pathlib import Path

from hfc_design import __version__
from hfc_design.controllers.genome import Genome, Population
from hfc_design.controllers.kind import kinds
from hfc_design.core.embedded_files import embedder
from hfc_design.core.numbers import Json
from hfc_design.core.plugins import References, sources
from hfc_design.core.records import UserError, checked
from hfc_design.files.design import Design
from hfc_design.files.named_scenario import renamed
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.evaluating import Evaluation


def genome_of(scenario: Scenario) -> Genome:
    """Return the genome of the search of ``scenario``.

    Raises:
        UserError: the scenario names no controller, and the default does not fit its machine.
    """
    if "controller" not in scenario.model_fields_set and (fault := scenario.unfit):
        why = f"has no [controller], and the default has an error: {fault}"
        raise UserError(f"{scenario.name}: {why}")
    kind = kinds().get(scenario.controller.kind)  # with a genome, or the scenario could not name it
    genome: Genome = kind.genome(scenario.controller, scenario.target)
    return genome


def design_of(individual: Population, scenario: Scenario) -> Design:
    """Return the design of a population of one."""
    return design_with(genome_of(scenario).record(individual), scenario)


def design_with(controller: Json, scenario: Scenario) -> Design:
    """Return a design for ``scenario`` with a ``controller`` as in a design file.

    Raises:
        UserError: the controller is not valid or cannot run.
    """
    own_parts = sources(parts_of(scenario, controller))
    carried = embedder()
    movable = renamed(scenario, lambda key, file: carried(file))
    data = {
        "name": scenario.name,
        "plant": scenario.plant.in_full(),
        "controller": {"sample_time_s": scenario.simulation.sample_time_s, **controller},
        "limits": scenario.limits.model_dump(exclude_none=True),
        "provenance": {
            "program": f"hfc-design {__version__}",
            **({"plugins": own_parts} if own_parts else {}),
            "scenario": movable.model_dump(mode="json", exclude_none=True),
        },
    }
    return checked(Design, data, f"{scenario.name}, kind {controller['kind']!r}", Path())


def with_score(design: Design, evaluation: Evaluation, scenario: Scenario) -> Design:
    """Return the design with the fitness, merit and metrics of its evaluation on a scenario."""
    score: Json = {"scenario": scenario.name, **evaluation.score(scenario.judge())}
    if evaluation.substeps > scenario.simulation.substeps:
        score["substeps"] = evaluation.substeps  # it diverges with fewer
    return design.model_copy(update={"score": score})


def noted(design: Design, more: Json) -> Design:
    """Return the design with the entries ``more`` added to its score."""
    return design.model_copy(update={"score": {**design.score, **more}})


def parts_of(scenario: Scenario, controller: Json) -> References:
    """Return (group, name) of the plant, fitness and strategy, and of the controller's kinds."""
    used = [("plant", scenario.plant.name), ("fitness", scenario.fitness.kind)]
    return [*used, ("strategy", scenario.search.preset), *kinds_of(controller)]


def kinds_of(controller: Json) -> References:
    """Return ("controller", kind) of a controller or its settings, and of nested controllers."""
    inside = [*controller.get("axes", {}).values(), *filter(None, [controller.get("inner")])]
    outer = [("controller", controller["kind"])]
    return outer + [kind for part in inside for kind in kinds_of(part)]
