"""Is a yes ever wrong? Random designs of random scenarios that are judged yes, in 48 substeps.

Scenarios are those that come with the package, with other durations, sensors, delays and
tolerances; designs are what a search of each kind of controller begins with, and where a random
walk from the best of them leads. Each that is judged
*yes* is simulated twice more, from two starts, in 48 substeps: where the last quarters of both
still differ by more than a tenth of what the scenario tolerates, it swings, and the yes was wrong.

    python -m experiments.judged_yes --yes 500
"""

import json
from collections import Counter
from pathlib import Path
from time import monotonic
from typing import Any

import click
import numpy as np

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.controllers.kind import kinds
from hfc_design.core.records import UserError
from hfc_design.runs.individuals import design_of, genome_of
from hfc_design.simulation.acceptance import YES
from hfc_design.simulation.evaluating import Evaluation

#: Scenarios to begin with; circles and programs have several axes.
BASES = (
    *("c-axis-ramp", "c-axis-step", "c-axis-sine", "c-axis-tolerances", "positioning-stage-move"),
    *("milling-table-sine", "milling-table-circle", "feed-drive-line", "feed-drive-circle"),
    *("five-axis-program", "feed-drive-hierarchy"),
)
#: Designs that are drawn at a time, how often, those of the best that are judged, substeps of the
#: check, and the largest step of the walk, as of a search's mutations.
DRAWN, WALKED, JUDGED, SUBSTEPS, STEP = 96, 4, 24, 48, 0.5
#: Where so many of the best are no yes, no more of them are judged.
HOPELESS = 4
#: What may still swing, as a share of the tolerance, and that as one of the largest reference
#: where the scenario has none.
SWING, TOLERATED = 0.1, 0.05
#: The second start is off by such a share of the way.
OFF = 0.01


def scenario_like(rng: np.random.Generator) -> tuple[str, dict[str, Any]]:
    """A scenario's name and what is changed of it."""
    base = str(rng.choice(BASES))
    found = api.load_scenario(base)
    whole = found.simulation.duration_s
    changes: dict[str, Any] = {
        "robust": {"spread": float(rng.choice([0.02, 0.05, 0.1, 0.2])), "unseen": 20},
        "stress": {"machines": 4, "rest_s": 5.0, "mode_inertia": [0.1]},
        "limits.delay_samples": int(rng.integers(0, 3)),
        "run.seed": int(rng.integers(1000)),
    }
    changes["robust"] |= {"first": 2, "machines": 2, "elite": 2, "final": 4}
    if not found.follows_path:
        changes["simulation.duration_s"] = whole * float(rng.choice([0.7, 1.0, 2.0]))
        changes["sensors.noise"] = _largest(found) * float(rng.choice([0.0, 1e-6, 1e-5]))
    if rng.random() < 0.5:
        changes["simulation.substeps"] = int(found.simulation.substeps * rng.choice([1, 2]))
    kind = str(rng.choice([*kinds().names()]))
    return base, changes | {"controller": {"kind": kind}, "search": {"preset": "race"}}


def _largest(scenario: api.Scenario) -> float:
    """Largest reference of a scenario, of all axes."""
    samples = scenario.each_motion()[0].samples()
    return max(float(np.ptp(axis.reference)) for axis in samples.axes)


def drawn(scenario: api.Scenario, rng: np.random.Generator) -> list[api.Design]:
    """The best of random designs that do not diverge, every second one, for a walk keeps near."""
    genome = genome_of(scenario)
    population = genome.fresh(rng.integers(0, genome.structures, DRAWN), rng)
    found: list[tuple[float, api.Design]] = []
    for _ in range(WALKED):
        designs, places = [], []
        for k in range(DRAWN):
            try:
                designs.append(design_of(taken(population, np.array([k])), scenario))
            except UserError:  # no controller that can run
                continue
            places.append(k)
        if not designs:
            return []
        merit = api.evaluate_many(designs, scenario).merit[:, 0, 0]
        merit = np.where(np.isfinite(merit), merit, -np.inf)
        found += [*zip(merit.tolist(), designs, strict=True)]
        parents = np.array(places)[np.argsort(-merit)[:JUDGED]]
        parents = np.resize(parents, DRAWN)
        population = genome.mutated(taken(population, parents), STEP * rng.random(DRAWN), rng)
    best = sorted((one for one in found if np.isfinite(one[0])), key=lambda one: -one[0])
    return [design for _, design in best[: 2 * JUDGED : 2]]


def swings(design: api.Design, scenario: api.Scenario) -> float:
    """By how much two starts still differ in the end, in shares of what is tolerated."""
    worst = 0.0
    for motion in scenario.each_motion():
        fine = {"simulation.substeps": SUBSTEPS}
        largest = _largest(motion)
        starts = {}
        for axis in motion.plant.each():
            place = float(motion.places[axis.name])
            starts[axis.name] = {axis.drive.position: place + OFF * largest}
        own = starts if len(starts) > 1 else next(iter(starts.values()))
        one = api.evaluate(design, api.load_scenario(motion, fine))
        other = api.evaluate(design, api.load_scenario(motion, {**fine, "start": own}))
        worst = max(worst, _apart(one, other) / (SWING * TOLERATED * largest))
    return worst


def _apart(one: Evaluation, other: Evaluation) -> float:
    """Half the range of what the last quarters of two motions differ by, the most of all axes."""
    found = []
    for a, b in zip(one.axes, other.axes, strict=True):
        off = np.asarray(a.motion.error) - np.asarray(b.motion.error)
        found.append(0.5 * float(np.ptp(off[3 * len(off) // 4 :])))
    return max(found) if all(map(np.isfinite, found)) else np.inf


@click.command()
@click.option("--yes", type=click.IntRange(1), default=500, help="Designs judged yes, at least.")
@click.option("--seed", type=int, default=0, help="Of scenarios and designs.")
@click.option("--minutes", type=float, default=600.0, help="Longest time.")
@click.option("--out", type=Path, default=Path("runs/judged-yes.json"), help="What was found.")
def main(yes: int, seed: int, minutes: float, out: Path) -> None:
    """Print how many designs that are judged yes swing."""
    rng, begun, rows = np.random.default_rng(seed), monotonic(), list[dict[str, Any]]()
    answers: Counter[str] = Counter()
    while answers[YES] < yes and monotonic() - begun < 60.0 * minutes:
        base, changes = scenario_like(rng)
        try:
            scenario = api.load_scenario(base, changes)
            designs = drawn(scenario, rng)
        except UserError as error:
            answers["refused"] += 1
            click.echo(f"{base} {changes['controller']['kind']}: {error}", err=True)
            continue
        before = answers[YES]
        for k, design in enumerate(designs):
            if k == HOPELESS and answers[YES] == before:
                break
            found = api.usable(design, scenario)
            answers[found.verdict] += 1
            if found.verdict == YES:
                off = swings(design, scenario)
                rows.append({"scenario": base, "changes": changes, "swings": off})
        wrong = sum(row["swings"] > 1.0 for row in rows)
        click.echo(f"{base} {changes['controller']['kind']}: {dict(answers)}, {wrong} swing")
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(json.dumps(rows, indent=1), "utf-8")


if __name__ == "__main__":
    main()
