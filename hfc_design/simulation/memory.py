"""Estimates of the largest memory of a run, made before it allocates any.

They were fitted to the peaks of whole processes of 0.2 to 6 GB; ``docs/memory.md`` shows how well.
"""

import os
import re
from pathlib import Path

import jax
import numpy as np

from hfc_design.controllers.genome import Genome
from hfc_design.core.records import UserError, either
from hfc_design.files.scenario import Scenario

#: Variable of the environment, so that workers have it too: what a run may hold, as in 8GB.
VARIABLE = "HFC_MEMORY"
#: What sets it; a script has no option for it.
LIMIT = either("--memory or ", "") + VARIABLE
#: Without it a run may hold this share of what the machine has free, and this much anyway.
SHARE, ANYWAY = 0.8, 1e9
#: Bytes of the program and what it compiles, of compiling a substep, and of each load and number
#: that is recorded in a sample, copies included.
PROGRAM, SUBSTEP, LOAD, NUMBER = 0.32e9, 1.8e6, 48, 26
#: Bytes of each derivative in a sample and of each machine; copies of an individual.
DERIVATIVE, MACHINE, COPIES = 27, 8_000, 9
#: What ``--memory`` may say behind its number.
UNITS = {"K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12, "": 1.0}
#: By the controller that /proc/self/cgroup names ("" in version 2): files with the limit of a group
#: and the memory that it uses [bytes], and the key of the part of it that is file cache, which the
#: system can free.
CONTROL_GROUPS = {
    "": ("memory.max", "memory.current", "inactive_file"),
    "memory": ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
}
#: What a run holds, by the keys and options that make it large.
Parts = dict[str, float]


def of_motion(scenario: Scenario, designs: int = 1) -> Parts:
    """Memory to simulate and keep every motion of so many ``designs`` [bytes]."""
    simulation, machine = scenario.simulation, scenario.plant.machine
    moments = (2 * simulation.substeps + 1) * len(machine.axes)
    numbers = 3 * len(machine.axes) + len(jax.tree.leaves(machine.initial_state(0.0)))
    numbers += 27 * scenario.follows_path  # what the contour error is made of
    each = LOAD * moments + NUMBER * (1 + 0.9 * (designs - 1)) * numbers
    compiled = SUBSTEP * simulation.substeps * len(machine.axes)
    steps = sum(motion.simulation.steps for motion in scenario.each_motion())
    return {"simulation.duration_s, sample_time_s, substeps": steps * each + compiled}


def of_search(scenario: Scenario, genome: Genome) -> Parts:
    """Memory of a search, and of a report beside other designs [bytes]."""
    one = genome.empty()
    individual = sum(np.asarray(leaf).nbytes for leaf in jax.tree.leaves(one)) / genome.structures
    parts = {"search.population": COPIES * individual * scenario.search.population}
    if getattr(scenario.search, "newton_steps", 0) and hasattr(genome, "space"):
        lanes = len(genome.space().frozen) + 16 * jax.device_count()
        steps = scenario.simulation.steps * (len(scenario.plant.machine.axes) == 1)
        parts["simulation.duration_s, search.newton_steps"] = DERIVATIVE * lanes * steps
    return parts | of_motion(scenario, 4)


def check(what: str, parts: Parts, at_once: int = 1) -> None:
    """Refuse a computation of which ``at_once`` together need more memory than allowed.

    Raises:
        UserError: they need more, or the limit is not a size.
    """
    needed, most = at_once * (PROGRAM + sum(parts.values())), max(parts, key=parts.__getitem__)
    if setting := os.environ.get(VARIABLE):
        allowed, source = size(setting), f"{LIMIT}: {setting}"
    else:
        allowed, source = max(SHARE * free(), ANYWAY), f"{SHARE:.0%} of the free memory"
    if needed > allowed:
        raise UserError(
            f"{what}: needs about {needed / 1e9:.3g} GB of memory, most by {most}; the "
            f"limit is {allowed / 1e9:.3g} GB ({source}); change these, or raise "
            + either("--memory", VARIABLE)
        )


def size(text: str) -> float:
    """Memory that the user's ``--memory`` gives [bytes].

    Raises:
        UserError: it is not a size.
    """
    match = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?) ?([KMGT]?)i?B?", text.strip(), re.I | re.A)
    if not match or not float(match[1]):
        raise UserError(f"{LIMIT} {text[:60]}: must be a size, as in 8GB")
    return float(match[1]) * UNITS[match[2].upper()]


def free() -> float:
    """Memory that this process could use now, within the limits of its groups [bytes]."""
    left = [1024 * _words(Path("/proc/meminfo")).get("MemAvailable:", np.inf)]
    for line in _text(Path("/proc/self/cgroup")).splitlines():
        _, controller, path = line.split(":", 2)
        if controller in CONTROL_GROUPS:
            top = Path("/sys/fs/cgroup", controller)
            group = top / path.strip("/")
            around = [place for place in group.parents if place.is_relative_to(top)]
            left += [_left_by(place, *CONTROL_GROUPS[controller]) for place in (group, *around)]
    resident = 1024 * _words(Path("/proc/self/status")).get("VmRSS:", 0)
    return resident + max(min(left), 0.0)


def _left_by(group: Path, limit: str, used: str, cached: str) -> float:
    """Memory that one control group leaves [bytes]; the texts are names of its files."""
    bound, now = _text(group / limit).strip(), _text(group / used).strip()
    if not (bound.isdigit() and now.isdigit()):  # "max", or there is no such group
        return np.inf
    return int(bound) - int(now) + _words(group / "memory.stat").get(cached, 0)


def _text(path: Path) -> str:
    try:
        return path.read_text()
    except OSError:
        return ""


def _words(path: Path) -> dict[str, float]:
    """Numbers of a file by the word that stands before each."""
    rows = (line.split() for line in _text(path).splitlines())
    return {row[0]: float(row[1]) for row in rows if len(row) > 1 and row[1].isdigit()}
