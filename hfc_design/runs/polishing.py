"""The design of a finished search polished, as far as that has come in the folder of its run."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hfc_design.controllers.genome import Population, taken
from hfc_design.core import checkpoint, interrupt
from hfc_design.core.numbers import Json
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.runs.champion import LEAST_VIOLATED
from hfc_design.runs.individuals import design_of, genome_of, with_score
from hfc_design.runs.polish_task import PolishTask
from hfc_design.runs.stored import SPARE, belongs
from hfc_design.search.by_numbers import coordinates
from hfc_design.search.polish import Polished, polish
from hfc_design.simulation.evaluating import Evaluation, evaluate

CHECKPOINT = "polish.npz"
#: Seconds between checkpoints.
CHECKPOINT_EVERY = 2.0
#: In the score of a design: how many steps, and what is ranked before and after them.
POLISH = "polish"


def check_polish(scenario: Scenario) -> None:
    """Refuse a polish of what has no coordinates to move in.

    Raises:
        UserError: it is asked for, and the kind of controller has none.
    """
    if not scenario.run.polish:
        return
    genome = genome_of(scenario)
    if coordinates(genome, taken(genome.empty(), slice(1))) is None:
        told = f"run.polish = {scenario.run.polish}: a controller of kind"
        raise UserError(f"{told} {scenario.controller.kind!r} cannot be polished; leave it 0")


def polished(
    scenario: Scenario,
    folder: Path,
    begun: tuple[Population, Design, Evaluation],
    made_by: dict[str, str],
    anyway: bool,
    on_step: Callable[[Polished], None],
) -> tuple[Design, Evaluation]:
    """What became of the design that it ``begun`` with, which stays where nothing is better.

    Stopped at any moment and called again, it ends the same.

    Raises:
        RunError: its checkpoint is damaged or not ``made_by`` the same, or the folder cannot be
            written.
    """
    individual, design, evaluation = begun
    path, steps = folder / CHECKPOINT, scenario.run.polish
    done = _loaded(path, scenario, {} if anyway else made_by)
    saved = time.monotonic()
    task = PolishTask(scenario, individual).task
    try:
        each = polish(task, individual, steps, scenario.run.seed, done)
        for done in each:
            interrupt.heard()
            on_step(done)
            if time.monotonic() - saved > CHECKPOINT_EVERY:
                checkpoint.save(path, done, made_by)
                saved = time.monotonic()
    finally:
        if done is not None:
            checkpoint.save(path, done, made_by)
    assert done is not None  # there is at least one step
    rank, first = float(done.worth[0, 0]), float(done.first[0, 0])
    if rank > first:
        better = design_of(done.population, scenario)
        found = evaluate(better, scenario)
        if scenario.ensemble or found.merit >= evaluation.merit:
            design, evaluation = with_score(better, found, scenario), found
            if scenario.ensemble and rank < 0.0:
                design = _noted(design, {LEAST_VIOLATED: True})
    numbers = {"steps": steps, "before": _finite(first), "after": _finite(rank)}
    return _noted(design, {POLISH: numbers}), evaluation


def polish_told(design: Design) -> str:
    """What a polish has brought, in a line; "" where there was none, or nobody can say."""
    found: Any = design.score.get(POLISH)
    try:
        ends = (found["before"], found["after"])
        before, after = ("none" if x is None else f"{x:.5g}" for x in ends)
        return f"polish: {found['steps']} steps, merit from {before} to {after}"
    except (KeyError, TypeError, ValueError):  # the file has been edited
        return ""


def _finite(rank: float) -> float | None:
    return rank if np.isfinite(rank) else None


def _noted(design: Design, told: Json) -> Design:
    return design.model_copy(update={"score": {**design.score, **told}})


def _loaded(path: Path, scenario: Scenario, needed: dict[str, str]) -> Polished | None:
    """The polish in a file; None where there is no such file.

    Raises:
        RunError: it is damaged, or made by something else than is ``needed``.
    """
    if not path.exists():
        return None
    genome = genome_of(scenario)
    one = taken(genome.empty(), slice(1))
    with checkpoint.doubted(path):
        made_by, arrays = checkpoint.read(path, 4 * SPARE)
        belongs(path, made_by, needed)
        done: Polished = checkpoint.record_of(Polished, {Population: one}, arrays)
        own = coordinates(genome, done.about)
        sizes = {len(done.population.tree), len(done.worth), len(done.first)}
        if not (1 <= done.step <= scenario.run.polish and own and sizes == {1}):
            raise ValueError("its steps cannot be")
        if done.distribution.mean.shape != (own.size,):
            raise ValueError("its distribution is of other numbers")
    return done
