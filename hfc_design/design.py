"""A design run: scenario -> search -> run folder, with a checkpoint that survives anything."""

import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hfc_design import __version__, checkpoint, simulate
from hfc_design.closed_loop import closed_loop
from hfc_design.controller_settings import HierarchicalSettings, LawSettings
from hfc_design.evaluate import Evaluation, evaluate, load_design
from hfc_design.fitness import without_sticking
from hfc_design.machine_settings import PlantSettings
from hfc_design.records import RunError, UserError, checked
from hfc_design.rulebase import Design, design_json, read_design
from hfc_design.scenarios import Scenario, load_scenario, renamed, scenario_toml
from hfc_design.search.fuzzy_genome import FuzzyGenome
from hfc_design.search.gains_genome import GainsGenome
from hfc_design.search.genome import Floats, Genome, Population
from hfc_design.search.hierarchical_genome import HierarchicalGenome
from hfc_design.search.lin_lee import LinLeeState
from hfc_design.search.loop import Search, generations, strategy
from hfc_design.search.newton import Linear, Newton
from hfc_design.search.race import RaceState
from hfc_design.search.settings import RaceSettings
from hfc_design.stability.stable_range import stable_range

CONFIG, CHECKPOINT, HISTORY, DESIGN = "config.toml", "checkpoint.npz", "history.csv", "design.json"
#: In the folder of a run that searches nothing: the design that it scores.
GIVEN = "given.json"
#: Seconds between checkpoints of a search that is faster than that.
CHECKPOINT_EVERY = 2.0
#: This many of the archive's best are simulated again in float64 before one is chosen.
FINALISTS = 16


class Result(NamedTuple):
    """What a run found."""

    design: Design
    evaluation: Evaluation
    search: Search | None  # None where the design was given


class Problem:
    """A scenario as what a search needs of it."""

    def __init__(self, scenario: Scenario):
        self.genome = genome_of(scenario)
        loop = closed_loop(scenario, self.genome.controller)
        penalty = scenario.search.stick_penalty
        if penalty:
            loop = loop._replace(fitness=without_sticking(loop.fitness, penalty))
        self._loop = loop
        self._plants = scenario.plant.values()
        self._samples = scenario.samples()
        self._dtype = np.dtype(scenario.run.precision)

    def scores(self, population: Population) -> Floats:
        """Score of every individual; nan where it diverged."""
        gains = self.genome.gains(population)
        return simulate.scores(self._loop, self._plants, self._samples, gains, self._dtype)

    @property
    def newton(self) -> Newton | None:
        """Gauss-Newton steps; only where the score is one of tracking errors of one axis."""
        if not isinstance(self.genome, HierarchicalGenome) or len(self._plants) > 1:
            return None
        return self.genome.stepped(self._linear)

    def _linear(self, individual: Population) -> Linear | None:
        """The tracking error about one individual; None where it cannot be differentiated."""
        gains = self.genome.gains(individual)
        error, jacobian = simulate.error_jacobian(
            self._loop, self._plants, self._samples, gains, self._dtype
        )
        finite = np.isfinite(error).all() and np.isfinite(jacobian).all()
        return Linear(error, jacobian) if finite else None


def genome_of(scenario: Scenario) -> Genome:
    """What the search of ``scenario`` varies."""
    settings = scenario.controller
    if isinstance(settings, HierarchicalSettings):
        return HierarchicalGenome(scenario.search, settings.layout())
    every = scenario.simulation.sample_time_s
    if isinstance(settings, LawSettings):
        return GainsGenome(settings.law, every)
    axes = scenario.plant.values()
    ranges = (stable_range(axis.gain, axis.time_constant, every) for axis in axes)
    return FuzzyGenome(
        settings.start,
        min(ranges, key=lambda found: found.k1),
        min(min(-axis.lowest_command, axis.highest_command) for axis in axes),
        settings.largest_integral_gain,
        settings.symmetric,
    )


def new_run(scenario: Scenario, folder: Path, given: Design | None = None) -> Scenario:
    """Create the run folder of ``scenario``; returns the scenario as the folder holds it.

    With a design that is ``given`` the run scores it and searches nothing.

    Raises:
        UserError: the folder already holds a run.
        RunError: the folder cannot be written.
    """
    if any((folder / name).exists() for name in (CONFIG, CHECKPOINT, DESIGN)):
        raise UserError(f"--out {folder}: already holds a run; add --resume or name another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        own = _with_own_tables(scenario, folder)
    except OSError as error:
        raise RunError(f"{folder}: cannot be written: {error.strerror or error}") from None
    if given is not None:
        _write_design(folder / GIVEN, given)
    checkpoint.write_whole(folder / CONFIG, scenario_toml(own).encode())
    return opened_run(folder)


def opened_run(folder: Path) -> Scenario:
    """The scenario of an existing run folder.

    Raises:
        UserError: there is no run in the folder.
    """
    if not (folder / CONFIG).exists():
        raise UserError(f"--out {folder}: holds no run to resume (no {CONFIG})")
    return load_scenario(str(folder / CONFIG))


def run(
    scenario: Scenario, folder: Path, on_generation: Callable[[Search], None] = lambda search: None
) -> Result:
    """Search from the start, or from the folder's checkpoint, and fill the folder.

    Stopped at any moment and called again, it ends with the same files as without the stop.

    Raises:
        RunError: the checkpoint is damaged or foreign, or the folder cannot be written.
    """
    if (folder / GIVEN).exists():
        return _scored(scenario, folder)
    problem = Problem(scenario)
    settings = scenario.search
    config = (folder / CONFIG).read_text(encoding="utf-8")
    path = folder / CHECKPOINT
    search = _stored(path, scenario, config)
    saved = time.monotonic()
    steps = generations(
        strategy(settings, problem.genome),
        problem.genome,
        settings.generations,
        scenario.run.seed,
        problem.scores,
        problem.newton,
        search,
    )
    try:
        for search in steps:
            on_generation(search)
            if time.monotonic() - saved > CHECKPOINT_EVERY:
                _save(folder, search, config)
                saved = time.monotonic()
    finally:
        if search is not None:
            _save(folder, search, config)
    assert search is not None  # there is at least one generation
    design, evaluation = champion(search, scenario)
    _write_design(folder / DESIGN, design)
    return Result(design, evaluation, search)


def _scored(scenario: Scenario, folder: Path) -> Result:
    """The run of a given design."""
    given = load_design(str(folder / GIVEN))
    evaluation = evaluate(given, scenario)
    design = with_score(given, evaluation, scenario)
    _write_design(folder / DESIGN, design)
    return Result(design, evaluation, None)


def with_score(design: Design, evaluation: Evaluation, scenario: Scenario) -> Design:
    """The design with its fitness and metrics on a scenario."""
    score = {"scenario": scenario.name, "fitness": evaluation.fitness, **evaluation.metrics}
    return design.model_copy(update={"score": score})


def _write_design(path: Path, design: Design) -> None:
    checkpoint.write_whole(path, (design_json(design) + "\n").encode())


def finished_run(folder: Path) -> tuple[Scenario, Result]:
    """The scenario and the result of a run that has ended, from its folder.

    Raises:
        UserError: there is no finished run in the folder, or its config or design is damaged.
        RunError: its checkpoint is damaged, foreign or gone.
    """
    for name in (CONFIG, DESIGN):
        if not (folder / name).exists():
            raise UserError(f"{folder}: holds no finished run (no {name})")
    scenario = opened_run(folder)
    config = (folder / CONFIG).read_text(encoding="utf-8")
    search = _stored(folder / CHECKPOINT, scenario, config)
    if search is None and not (folder / GIVEN).exists():
        raise RunError(f"{folder / CHECKPOINT}: is gone; what the search did is not known")
    design = read_design(folder / DESIGN)
    return scenario, Result(design, evaluate(design, scenario), search)


def champion(search: Search, scenario: Scenario) -> tuple[Design, Evaluation]:
    """The best of the archive and of the last generation in float64.

    float32 and a single try flatter loops that are nearly chaotic.
    """
    found = []
    for source in (search.archive, search.state):
        order = np.argsort(-source.score, kind="stable")[:FINALISTS]
        for k in order[np.isfinite(source.score[order])]:  # a tree never tried has no score
            design = design_of(source.population.take(np.array([k])), scenario)
            found.append((design, evaluate(design, scenario)))
    penalty = scenario.search.stick_penalty

    def merit(item: tuple[Design, Evaluation]) -> float:
        return item[1].fitness / (1.0 + penalty * (item[1].metrics.get("stick_share") or 0.0))

    design, evaluation = max(found, key=merit)
    return with_score(design, evaluation, scenario), evaluation


def design_of(individual: Population, scenario: Scenario) -> Design:
    """A population of one as a design file."""
    return design_with(genome_of(scenario).record(individual), scenario)


def design_with(controller: dict[str, Any], scenario: Scenario) -> Design:
    """A controller as a design file spells it, its sample time left out, for ``scenario``.

    Raises:
        UserError: it is no controller that can run.
    """
    return checked(
        Design,
        {
            "name": scenario.name,
            "plant": _plant(scenario.plant),
            "controller": {"sample_time_s": scenario.simulation.sample_time_s, **controller},
            "provenance": {
                "program": f"hfc-design {__version__}",
                "scenario": renamed(scenario, lambda key, file: Path(file.name)).model_dump(
                    mode="json", exclude_none=True
                ),
            },
        },
        scenario.name,
        Path(),
    )


def _plant(settings: PlantSettings) -> dict[str, Any]:
    """The machine in full, so that the design does not depend on a program's defaults."""
    found = [record._asdict() for record in settings.values()]
    if not settings.axes:
        return {"name": settings.name, "parameters": found[0]}
    axes = dict(zip(settings.axes, found, strict=True))
    return {"name": settings.name, "parameters": {}, "axes": axes}


def _stored(path: Path, scenario: Scenario, config: str) -> Search | None:
    if not path.exists():
        return None
    kinds = {
        "state": RaceState if isinstance(scenario.search, RaceSettings) else LinLeeState,
        "population": type(genome_of(scenario).empty()),
    }
    search: Search = checkpoint.load(path, Search, kinds, config)
    return search


def _save(folder: Path, search: Search, config: str) -> None:
    checkpoint.save(folder / CHECKPOINT, search, config)
    lines = ["generation,best,median,diverged,structures"]
    columns = (column.tolist() for column in search.history)
    for k, (best, median, diverged, structures) in enumerate(zip(*columns, strict=True)):
        lines.append(f"{k},{best!r},{median!r},{diverged},{structures}")
    checkpoint.write_whole(folder / HISTORY, ("\n".join(lines) + "\n").encode())


def _with_own_tables(scenario: Scenario, folder: Path) -> Scenario:
    """Copy the files that a scenario names into the run folder, so that it stands alone."""

    def copied(key: str, file: Path) -> Path:
        name = key + file.suffix
        shutil.copyfile(file, folder / name)
        return Path(name)

    return renamed(scenario, copied)
