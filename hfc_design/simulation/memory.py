"""Estimates of the largest memory of a run, made before it allocates any.

They were fitted to the peaks of whole processes of 0.2 to 6 GB; ``docs/memory.md`` shows how well.
"""

import os
import re
from pathlib import Path

import jax
import numpy as np
import psutil

from hfc_design.controllers.genome import Genome
from hfc_design.core.records import UserError, either
from hfc_design.files.scenario import Scenario

#: Environment variable with the memory that a run may use, as in 8GB; workers inherit it.
VARIABLE = "HFC_MEMORY"
#: How a user sets this limit; a script has no option for it.
LIMIT = either("--memory or ", "") + VARIABLE
#: Without a limit a run may use this share of the free memory, or this much if it is more [bytes].
SHARE, ANYWAY = 0.8, 1e9
#: Bytes of the process with its compiled programs, of compiling a substep, of a load and of a
#: recorded number in each sample; copies are included.
PROGRAM, SUBSTEP, LOAD, NUMBER = 0.32e9, 1.8e6, 48, 26
#: Bytes of a derivative in each sample, and of a machine; number of copies of an individual.
DERIVATIVE, MACHINE, COPIES = 27, 8_000, 9
#: Units that may follow the number in ``--memory`` [bytes].
UNITS = {"K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12, "": 1.0}
#: Control groups of Linux: controller in /proc/self/cgroup ("" in version 2) -> name of the file
#: with the limit, name of the file with the used memory [bytes], and key (in memory.stat) of the
#: file cache in the used memory, which the system can free.
CONTROL_GROUPS = {
    "": ("memory.max", "memory.current", "inactive_file"),
    "memory": ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
}
#: Parts of the memory of a run [bytes], by the keys and options that make them large.
Parts = dict[str, float]


def of_motion(scenario: Scenario, designs: int = 1) -> Parts:
    """Return the memory to simulate and keep every motion of so many ``designs`` [bytes]."""
    simulation, machine = scenario.simulation, scenario.plant.machine
    moments = (2 * simulation.substeps + 1) * len(machine.axes)
    numbers = 3 * len(machine.axes) + len(jax.tree.leaves(machine.initial_state(0.0)))
    numbers += 27 * scenario.follows_path  # from which the contour error is computed
    each = LOAD * moments + NUMBER * (1 + 0.9 * (designs - 1)) * numbers
    compiled = SUBSTEP * simulation.substeps * len(machine.axes)
    steps = sum(motion.simulation.steps for motion in scenario.each_motion())
    return {"simulation.duration_s, sample_time_s, substeps": steps * each + compiled}


def of_search(scenario: Scenario, genome: Genome) -> Parts:
    """Return the memory of a search, and of a report that compares other designs [bytes]."""
    one = genome.empty()
    individual = sum(np.asarray(leaf).nbytes for leaf in jax.tree.leaves(one)) / genome.structures
    parts = {"search.population": COPIES * individual * scenario.search.population}
    if getattr(scenario.search, "newton_steps", 0) and hasattr(genome, "space"):
        lanes = len(genome.space().frozen) + 16 * jax.device_count()
        steps = scenario.simulation.steps * (len(scenario.plant.machine.axes) == 1)
        parts["simulation.duration_s, search.newton_steps"] = DERIVATIVE * lanes * steps
    return parts | of_motion(scenario, 4)


def check(what: str, parts: Parts, at_once: int = 1) -> None:
    """Check that ``at_once`` computations together need no more memory than allowed.

    Raises:
        UserError: they need more, or the limit in the environment is not a size.
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
    """Return the size in a user's text, such as 8GB [bytes]; UserError: it is not a size."""
    match = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?) ?([KMGT]?)i?B?", text.strip(), re.I | re.A)
    if not match or not float(match[1]):
        raise UserError(f"{LIMIT} {text[:60]}: must be a size, as in 8GB")
    return float(match[1]) * UNITS[match[2].upper()]


def free() -> float:
    """Return the memory that this process may use now, in total, in its control groups [bytes]."""
    left = [float(psutil.virtual_memory().available)]
    for line in _text(Path("/proc/self/cgroup")).splitlines():
        _, controller, path = line.split(":", 2)
        if controller in CONTROL_GROUPS:
            top = Path("/sys/fs/cgroup", controller)
            group = top / path.strip("/")
            around = [place for place in group.parents if place.is_relative_to(top)]
            left += [_left_by(place, *CONTROL_GROUPS[controller]) for place in (group, *around)]
    return psutil.Process().memory_info().rss + max(min(left), 0.0)


def _left_by(group: Path, limit: str, used: str, cached: str) -> float:
    """Return the memory that a control group leaves [bytes]; texts as in ``CONTROL_GROUPS``."""
    bound, now = _text(group / limit).strip(), _text(group / used).strip()
    if not (bound.isdigit() and now.isdigit()):  # "max", or there is no such group
        return np.inf
    cache = re.search(rf"^{cached} (\d+)$", _text(group / "memory.stat"), re.M)
    return int(bound) - int(now) + (int(cache[1]) if cache else 0)


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8")
    except OSError:
        return ""
