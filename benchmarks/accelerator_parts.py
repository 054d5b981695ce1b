"""What ``accelerator.py`` measures, one part in a process: python accelerator_parts.py NAME GIVEN.

GIVEN is a list in JSON. The last line of the output is JSON: numbers, or an error's first line.
"""

import json
import resource
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import contender
import evaluator_peer
import jax
import numpy as np
from work import load, save

from hfc_design.calls.searching import design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation import compiled
from hfc_design.simulation.stepping import Inputs

#: Largest relative deviation of a score in float32 from float64 on the processor.
TOLERANCE = 2e-5
CHECKED, SAMPLES, TURNS = 64, 1000, 5


def check(file: str) -> dict[str, float]:
    """Scores in float32 here against those in float64 that the processor leaves in a file."""
    path = Path(file)
    if jax.default_backend() == "cpu":
        work, scores = evaluator_peer.stable(CHECKED, SAMPLES)
        save(work, path)
        np.save(path.with_suffix(".npy"), scores)
    return deviation(evaluator_peer.prepare(load(path))(), np.load(path.with_suffix(".npy")))


def deviation(found: np.ndarray, exact: np.ndarray) -> dict[str, float]:
    """Largest and median relative deviation; ArithmeticError: the largest is not allowed."""
    relative = np.abs(found / exact - 1.0)
    if not relative.max() <= TOLERANCE:  # a nan is none either
        told = f"a score deviates by {relative.max():.1e} from float64, allowed is {TOLERANCE:.0e}"
        raise ArithmeticError(told)
    return {"deviation": float(relative.max()), "median_deviation": float(np.median(relative))}


def speed(individuals: int, machines: int, turning_s: float) -> dict[str, Any]:
    """Turns of individuals on one machine, or each on many; no turn is begun after a time."""
    begun = time.monotonic()
    run = evaluator_peer.on_machines(evaluator_peer.many(individuals, SAMPLES), machines)
    turns = [contender.seconds(run, 1)]
    while len(turns) < TURNS and time.monotonic() - begun < turning_s:
        turns.append(contender.seconds(run, 1))
    took, peak = float(np.median(turns)), (jax.devices()[0].memory_stats() or {})
    found = {"turns_s": turns, "took_s": took, "device_bytes": peak.get("peak_bytes_in_use")}
    found["steps_per_s"] = individuals * machines * SAMPLES / took
    return found | (on_the_way(*run.args) if machines == 1 else {})


def on_the_way(loop: Any, machines: Any, motions: Any, gains: Any, dtype: Any) -> dict[str, Any]:
    """How long the numbers of a turn take to be packed, and to reach the first device."""
    width = compiled.filled(gains.kp.size)
    lanes = np.minimum(np.arange(width), gains.kp.size - 1)  # the last one fills up
    filled = jax.tree.map(lambda leaf: leaf[..., lanes], gains)
    inputs, numbers = Inputs(loop.apart[1], *machines.one, motions[0], filled), []
    form = False, dtype, compiled.together(width)
    pack_s = contender.seconds(lambda: numbers.extend(inputs.packed(*form)[1:]), 1)
    move_s = contender.seconds(lambda: jax.block_until_ready(jax.device_put(numbers)), 3)
    moved = sum(leaf.nbytes for leaf in jax.tree.leaves(numbers))
    return {"pack_s": pack_s, "move_s": move_s, "moved_bytes": moved}


def search(scenario: str, changes: Mapping[str, Any], generations: int) -> dict[str, Any]:
    """A whole search on machines that it draws, as ``hfc design`` runs it, by generations."""
    marks = [time.perf_counter()]
    asked = load_scenario(scenario, {**changes, "search.generations": generations})
    result = design(asked, None, lambda _: marks.append(time.perf_counter()))
    took = time.perf_counter() - marks[0]
    times = {"turns_s": np.diff(marks[1:]).tolist(), "first_s": marks[1] - marks[0]}
    return {**times, "took_s": took, "merit": result.evaluation.merit}


def main(name: str, given: str) -> dict[str, Any]:
    """What a part says."""
    functions: dict[str, Any] = {"check": check, "speed": speed, "search": search}
    compiling: list[float] = []
    jax.monitoring.register_event_duration_secs_listener(
        lambda event, took, **_: compiling.append(took if "/core/compile/" in event else 0.0)
    )
    try:
        found = functions[name](*json.loads(given))
    except Exception as error:  # whatever a card and its driver come up with
        return {"state": "failed", "told": f"{type(error).__name__}: {error}".splitlines()[0]}
    own = {"devices": f"{jax.device_count()} x {jax.devices()[0].device_kind}"}
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return {"state": "measured", **own, **found, "compile_s": sum(compiling), "host_bytes": peak}


if __name__ == "__main__":
    print(json.dumps(main(*sys.argv[1:])))
