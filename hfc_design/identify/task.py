"""What is to be identified: which machine, of it which parameters, and in which loop."""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.core.dotted import Changes, changed
from hfc_design.core.numbers import NUMBER
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.identify.free import LATE, LOAD, Free, free


class Task(NamedTuple):
    """What is to be identified, and how."""

    scenario: Scenario  # its plant with the values to start from, sensors, limits
    axis: int  # which one
    design: Design | None  # the controller in the loop that recorded the logs
    names: Sequence[str] | None  # parameters that are looked for; None: all that may be
    bandwidth: float | None  # of the observer [Hz]; 0: open loop; None: that of the least residual
    seed: int = 0
    made: bool = False  # the scenario says no more than which machine it is
    known: frozenset[str] = frozenset()  # what stays as it is; see ``known``


def known(changes: Changes, axis: str) -> frozenset[str]:
    """What somebody has set of an axis: parameters, the load that is always there, ``LATE``."""
    told = changed({}, changes)

    plant, load, limits = (told.get(table, {}) for table in ("plant", "load", "limits"))
    axes = [part.get("axes", {}).get(axis, {}) for part in (plant, load, limits)]
    names = {*plant.get("parameters", {}), *axes[0], *({*limits, *axes[2]} & {*LATE})}
    return frozenset(names | ({LOAD} if "constant" in (*load, *axes[1]) else set()))


def looked_for(task: Task) -> Free:
    """The parameters that are looked for.

    Raises:
        UserError: one is unknown, is known already, or has no value to start from.
    """
    start = task.scenario.plant.each()[task.axis]
    nominal = start.drive.parameters()._asdict()
    own = {k: x for k, x in start.parameters._asdict().items() if x != nominal[k]}
    named = [name.partition("=") for name in task.names or ()]
    names = [name.strip() for name, *_ in named]
    load = task.scenario.load.of(start.name).constant
    try:
        begun = {name.strip(): _number(name.strip(), x) for name, told, x in named if told}
        if both := task.known & {*names}:
            one = min(both, key=names.index)
            raise ValueError(f"{one}: is known by --set; leave out one of them")
        around = begun.pop(LOAD, load), *lateness(task.scenario, start.name)
        if begun.keys() <= nominal.keys() and (fault := start.drive.fault(own | begun)):
            raise ValueError(fault.removeprefix("parameters."))
        return free(start.drive, own | begun, names or None, task.known, around)
    except ValueError as error:
        raise UserError(f"--free {error}") from None


def _number(name: str, text: str) -> float:
    if not NUMBER.fullmatch(text.strip()):
        told = f"has to begin at a number, as in {name}=0.1 (got {text[:40]!r})"
        raise ValueError(f"{name}: {told}")
    return float(text)


def lateness(scenario: Scenario, axis: str) -> tuple[float, float]:
    """By how many samples commands are late in a scenario in all, and which part is a lag."""
    limits = scenario.limits.of(axis)
    lag = getattr(limits, "lag_s", 0.0) / scenario.simulation.sample_time_s
    return limits.delay_samples + lag, lag
