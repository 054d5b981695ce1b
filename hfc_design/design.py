"""A design run: scenario -> search -> run folder, with a checkpoint that survives anything."""

import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hfc_design import __version__, checkpoint, hierarchy, simulate
from hfc_design.controllers import hierarchical
from hfc_design.evaluate import Evaluation, evaluate
from hfc_design.fitness import without_sticking
from hfc_design.records import RunError, UserError
from hfc_design.rulebase import Design, design_json
from hfc_design.scenarios import PlantSettings, Scenario, load_scenario, scenario_toml
from hfc_design.search.genome import Floats, Population, controller_gains
from hfc_design.search.lin_lee import LinLeeState
from hfc_design.search.loop import Search, generations, strategy
from hfc_design.search.newton import Linear
from hfc_design.search.race import RaceState
from hfc_design.search.settings import RaceSettings

CONFIG, CHECKPOINT, HISTORY, DESIGN = "config.toml", "checkpoint.npz", "history.csv", "design.json"
#: Seconds between checkpoints of a search that is faster than that.
CHECKPOINT_EVERY = 2.0
#: This many of the archive's best are simulated again in float64 before one is chosen.
FINALISTS = 16


class Result(NamedTuple):
    """What a run found."""

    design: Design
    evaluation: Evaluation
    search: Search


class Problem:
    """A scenario as the two functions that a search calls."""

    def __init__(self, scenario: Scenario):
        self.layout = scenario.controller.layout()
        loop = simulate.closed_loop(scenario, hierarchical(self.layout))
        penalty = scenario.search.stick_penalty
        if penalty:
            loop = loop._replace(fitness=without_sticking(loop.fitness, penalty))
        self._loop = loop
        self._plants = scenario.plant.values()
        self._samples = scenario.samples()
        self._dtype = np.dtype(scenario.run.precision)

    def scores(self, population: Population) -> Floats:
        """Score of every individual; nan where it diverged."""
        gains = controller_gains(population)
        return simulate.scores(self._loop, self._plants, self._samples, gains, self._dtype)

    def linear(self, individual: Population) -> Linear | None:
        """The tracking error about one individual; None where it cannot be differentiated."""
        gains = controller_gains(individual)
        error, jacobian = simulate.error_jacobian(
            self._loop, self._plants, self._samples, gains, self._dtype
        )
        finite = np.isfinite(error).all() and np.isfinite(jacobian).all()
        return Linear(error, jacobian) if finite else None


def new_run(scenario: Scenario, folder: Path) -> Scenario:
    """Create the run folder of ``scenario``; returns the scenario as the folder holds it.

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
    problem = Problem(scenario)
    settings = scenario.search
    config = (folder / CONFIG).read_text(encoding="utf-8")
    path = folder / CHECKPOINT
    search = _stored(path, settings, config)
    saved = time.monotonic()
    steps = generations(
        strategy(settings, problem.layout),
        problem.layout,
        settings.generations,
        scenario.run.seed,
        problem.scores,
        problem.linear,
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
    checkpoint.write_whole(folder / DESIGN, (design_json(design) + "\n").encode())
    return Result(design, evaluation, search)


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
    score = {"scenario": scenario.name, "fitness": evaluation.fitness, **evaluation.metrics}
    return design.model_copy(update={"score": score}), evaluation


def design_of(individual: Population, scenario: Scenario) -> Design:
    """A population of one as a design file."""
    settings = scenario.controller
    names = [item.name for item in settings.inputs]
    tree = hierarchy.trees(len(names))[int(individual.tree[0])]
    sources = names + [f"unit-{unit.heap_id}" for unit in tree]
    kp, kd = individual.gains[0].tolist()
    controller = {
        "kind": "pd+hierarchical-fuzzy",
        "sample_time_s": scenario.simulation.sample_time_s,
        "pd": {"kp": kp, "kd": kd},
        "inputs": [
            {"name": name, "scale": scale}
            for name, scale in zip(names, individual.scales[0].tolist(), strict=True)
        ],
        "output_scale": settings.output_scale,
        "terms": [term.model_dump() for term in settings.terms],
        "units": [
            {
                "id": unit.heap_id,
                "column_input": sources[unit.column],
                "row_input": sources[unit.row],
                "consequents": table.tolist(),
            }
            for unit, table in zip(tree, individual.consequents[0], strict=True)
        ],
        "adaptation": settings.adaptation.model_dump() if settings.adaptation else None,
    }
    return Design.model_validate(
        {
            "name": scenario.name,
            "plant": _plant(scenario.plant),
            "controller": controller,
            "provenance": {
                "program": f"hfc-design {__version__}",
                "scenario": _renamed(scenario, lambda key, file: Path(file.name)).model_dump(
                    mode="json", exclude_none=True
                ),
            },
        }
    )


def _plant(settings: PlantSettings) -> dict[str, Any]:
    """The machine in full, so that the design does not depend on a program's defaults."""
    found = [record._asdict() for record in settings.values()]
    if not settings.axes:
        return {"name": settings.name, "parameters": found[0]}
    axes = dict(zip(settings.axes, found, strict=True))
    return {"name": settings.name, "parameters": {}, "axes": axes}


def _stored(path: Path, settings: Any, config: str) -> Search | None:
    if not path.exists():
        return None
    state = RaceState if isinstance(settings, RaceSettings) else LinLeeState
    search: Search = checkpoint.load(path, Search, state, config)
    return search


def _save(folder: Path, search: Search, config: str) -> None:
    checkpoint.save(folder / CHECKPOINT, search, config)
    lines = ["generation,best,median,diverged,structures"]
    columns = (column.tolist() for column in search.history)
    for k, (best, median, diverged, structures) in enumerate(zip(*columns, strict=True)):
        lines.append(f"{k},{best!r},{median!r},{diverged},{structures}")
    checkpoint.write_whole(folder / HISTORY, ("\n".join(lines) + "\n").encode())


def _with_own_tables(scenario: Scenario, folder: Path) -> Scenario:
    """Copy the CSV files that a scenario names into the run folder, so that it stands alone."""

    def copied(key: str, file: Path) -> Path:
        shutil.copyfile(file, folder / f"{key}.csv")
        return Path(f"{key}.csv")

    return _renamed(scenario, copied)


def _renamed(scenario: Scenario, name: Callable[[str, Path], Path]) -> Scenario:
    """The scenario with other paths to its CSV files."""
    changes: dict[str, Any] = {}
    for key in ("reference", "load"):
        record = getattr(scenario, key)
        file = getattr(record, "file", None)
        if file is not None:
            changes[key] = record.model_copy(update={"file": name(key, file)})
    return scenario.model_copy(update=changes)
