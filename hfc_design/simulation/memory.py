"""How much memory a run will hold at most, told before anything of it is allocated.

Fitted to the peaks of whole processes of 0.2 to 6 GB; ``docs/memory.md`` has how well.
"""

import os
import re
from pathlib import Path

import jax
import numpy as np

from hfc_design.controllers.genome import Genome
from hfc_design.core.records import UserError
from hfc_design.files.scenario import Scenario

#: Variable of the environment, so that workers have it too: what a run may hold, as in 8GB.
VARIABLE = "HFC_MEMORY"
#: Without it a run may hold this share of what the machine has free, and this much anyway.
SHARE, ANYWAY = 0.8, 1e9
#: Bytes of the program and what it compiles, of compiling a substep, and of each load and number
#: that is recorded in a sample, copies included.
PROGRAM, SUBSTEP, LOAD, NUMBER = 0.32e9, 1.8e6, 48, 26
#: Bytes of each derivative in a sample and of each machine; copies of an individual.
DERIVATIVE, MACHINE, COPIES = 27, 8_000, 9
UNITS = {"K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12, "": 1.0}
#: What a run holds, by the keys and options that make it large.
Parts = dict[str, float]


def of_motion(scenario: Scenario, designs: int = 1) -> Parts:
    """Simulating and keeping the motion of so many ``designs`` [bytes]."""
    simulation, machine = scenario.simulation, scenario.plant.machine
    moments = (2 * simulation.substeps + 1) * len(machine.axes)
    numbers = 3 * len(machine.axes) + len(jax.tree.leaves(machine.initial_state(0.0)))
    numbers += 27 * scenario.follows_path  # what the contour error is made of
    each = LOAD * moments + NUMBER * (1 + 0.9 * (designs - 1)) * numbers
    compiled = SUBSTEP * simulation.substeps * len(machine.axes)
    return {"simulation.duration_s, sample_time_s, substeps": simulation.steps * each + compiled}


def of_search(scenario: Scenario, genome: Genome) -> Parts:
    """Searching, and a report beside other designs [bytes]."""
    one = genome.empty()
    individual = sum(np.asarray(leaf).nbytes for leaf in jax.tree.leaves(one)) / genome.structures
    found = {"search.population": COPIES * individual * scenario.search.population}
    if getattr(scenario.search, "newton_steps", 0) and hasattr(genome, "space"):
        lanes = len(genome.space().frozen) + 16 * jax.device_count()
        steps = scenario.simulation.steps * (len(scenario.plant.machine.axes) == 1)
        found["simulation.duration_s, search.newton_steps"] = DERIVATIVE * lanes * steps
    return found | of_motion(scenario, 4)


def check(what: str, parts: Parts, at_once: int = 1) -> None:
    """Refuse what needs more memory than is allowed, ``at_once`` of it.

    Raises:
        UserError: it does, or the bound is none.
    """
    needed, most = at_once * (PROGRAM + sum(parts.values())), max(parts, key=parts.__getitem__)
    if told := os.environ.get(VARIABLE):
        allowed, source = size(told), f"--memory {told}"
    else:
        allowed, source = max(SHARE * free(), ANYWAY), f"{SHARE:.0%} of what is free"
    if needed > allowed:
        raise UserError(
            f"{what}: needs about {needed / 1e9:.3g} GB of memory, most by {most}; allowed are "
            f"{allowed / 1e9:.3g} GB ({source}); change these, or give another --memory"
        )


def size(text: str) -> float:
    """What ``--memory`` says [bytes].

    Raises:
        UserError: it is no size.
    """
    found = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?) ?([KMGT]?)i?B?", text.strip(), re.IGNORECASE)
    if not found or not float(found[1]):
        raise UserError(f"--memory or {VARIABLE} {text[:60]}: has to be a size, as in 8GB")
    return float(found[1]) * UNITS[found[2].upper()]


def free() -> float:
    """What this process could hold with what is free now [bytes], and its groups allow."""
    lines = _words(Path("/proc/meminfo"))
    rest = [1024.0 * lines["MemAvailable:"]] if "MemAvailable:" in lines else []
    for line in _text(Path("/proc/self/cgroup")).splitlines():
        _, names, path = line.split(":", 2)
        top = Path("/sys/fs/cgroup", *(["memory"] if names == "memory" else []))
        files = {"": ("memory.max", "memory.current", "inactive_file")}
        files["memory"] = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        place = top / path.strip("/")
        while names in files and place.is_relative_to(top):
            limit, used, cached = files[names]
            bound, now = _text(place / limit).strip(), _text(place / used).strip()
            if bound.isdigit() and now.isdigit():  # "max" is none
                rest.append(int(bound) - int(now) + _words(place / "memory.stat").get(cached, 0))
            place = place.parent
    own = _words(Path("/proc/self/status")).get("VmRSS:", 0) * 1024
    return own + max(min(rest, default=np.inf), 0.0)


def _text(path: Path) -> str:
    try:
        return path.read_text()
    except OSError:
        return ""


def _words(path: Path) -> dict[str, int]:
    """Numbers of a file by the word that stands before each."""
    rows = (line.split() for line in _text(path).splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) > 1 and row[1].isdigit()}
