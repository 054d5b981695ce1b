"""What the parameters do on each log, and what speaks against them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.files.design import Design
from hfc_design.files.scenario import Scenario
from hfc_design.identify.certainty import Certainty
from hfc_design.identify.fit import Fit, offs
from hfc_design.identify.loop import loop
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import Residual, replay
from hfc_design.identify.search import Found, observer

#: A residual above this share of the motion is no replay of it.
LOST = 0.2
#: A second log that is so many times as far off as the first one is not of the same machine.
STRANGE = 4.0


class Check(NamedTuple):
    """A log replayed with the parameters that were found, or with those of the start."""

    log: str
    how: str  # under the recorded command, or in closed loop
    before: float  # rms residual with the parameters of the start [unit of the position]
    after: float
    residual: Floats  # (steps,) recorded less simulated


def checked(
    scenario: Scenario, design: Design | None, found: Found, logs: dict[str, Recording]
) -> tuple[Check, ...]:
    """Every log replayed in every way that there is; ``design`` is the loop that recorded them."""
    checks: list[Check] = []
    for name, told in logs.items():
        ways: dict[str, Residual] = {}
        if told.command is not None and found.bandwidth is not None:
            own = replay(found.fit.free, told, found.bandwidth, scenario.simulation.substeps)
            ways[how_of(found)] = own
        if design is not None and told.reference is not None:
            ways["closed loop"] = loop(scenario, design, told)
        for how, residual in ways.items():
            problem = found.problem._replace(residual=residual)
            before, after = (  # of the position
                offs(problem, numbers)[:, 0]
                for numbers in (found.fit.free.begun, found.fit.numbers)
            )
            first, last = (float(np.sqrt(np.mean(off**2))) for off in (before, after))
            checks.append(Check(name, how, first, last, after))
    return tuple(checks)


def how_of(found: Found) -> str:
    """How a log was replayed, in words."""
    return f"{'recorded command, ' * (found.bandwidth is not None)}{observer(found.bandwidth)}"


def doubts(name: str, found: Found, known: Certainty, told: Recording, pushed: bool) -> list[str]:
    """What a user has to know before he uses the parameters.

    ``pushed``: other axes act on this one.
    """
    fit, notes = found.fit, list[str]()
    share = float(fit.rms[0] / max(np.std(told.place), 1e-300))
    if share > LOST:
        notes.append(
            f"NOT USABLE: the best replay is {100 * share:.3g} % of the motion off (rms); is it "
            "this machine, and are the columns and units right?"
        )
    if told.command is not None:
        notes += beyond(fit, told.command)
    if pushed:
        notes.append(
            "DOUBTFUL: the axes of this machine push one another, and one is replayed alone: what "
            "the others do to it has to be in the load"
        )
    if not any(known.told):
        gone, unit = float(np.ptp(told.place)), fit.free.drive.units["error"]
        notes.append(
            f"NOT USABLE: {name} tells none of the parameters: does the axis move in it, and is "
            f"its unit right? it goes {gone:.5g} {unit} in {told.sample_time * len(told.place):.3g}"
            " s"
        )
    for parameter, factor in fit.free.away(fit.numbers).items():
        if dict(zip(fit.free.names, known.told, strict=True))[parameter]:
            notes.append(
                f"DOUBTFUL: {name} is only replayed with {factor:.3g} times the {parameter} that "
                "it began with; are the units of its columns right, mm or m, say?"
            )
    low, high = known.late
    if low > 0.0 or high < 0.0:
        ms, word = 1e3 * abs(fit.late) * told.sample_time, "later" if fit.late > 0 else "earlier"
        notes.append(
            f"the command acts {ms:.2g} ms {word} than its samples say ({fit.late:+.2f} samples)"
        )
    return notes


def beyond(fit: Fit, command: Floats) -> list[str]:
    """What to say where the drive does not take all of a recorded command."""
    drive = fit.free.drive
    low, high = drive.largest_commands(fit.free.parameters(fit.numbers))
    share = float(np.mean((command < low) | (command > high)))
    if not share:
        return []
    return [
        f"{100 * share:.2g} % of the commands are beyond the {low:.4g} to {high:.4g} "
        f"{drive.units['command']} that the drive takes, and act as those: is that limit, and is "
        "the unit of the command right?"
    ]


def strangers(checks: Sequence[Check], logs: dict[str, Recording]) -> list[str]:
    """Which logs are not of the machine that the first one was identified by."""
    first = {check.how: check for check in checks if check.log == next(iter(logs))}
    notes = []
    for check in checks:
        own = first.get(check.how)
        if own is None or own is check:
            continue
        if not check.after <= STRANGE * max(own.after, 1e-9 * float(np.std(logs[check.log].place))):
            times = check.after / max(own.after, 1e-300)
            notes.append(
                f"DOUBTFUL: {check.log} is replayed {times:.3g} times worse than {own.log} "
                f"({check.how}): another machine, another load or another unit?"
            )
    return notes
