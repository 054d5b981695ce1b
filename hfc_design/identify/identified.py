"""A machine and its logs -> what they tell of it, and what speaks against that."""

from collections.abc import Sequence

import numpy as np

from hfc_design.core.numbers import Floats
from hfc_design.core.plugins import own_code
from hfc_design.core.records import UserError
from hfc_design.core.texts import about
from hfc_design.identify.advice import advice, profiles
from hfc_design.identify.fit import Fit, Found, Tell, bandwidths, by_command, by_starts, offs
from hfc_design.identify.identifiability import Certainty, certainty, fault, halved, kept
from hfc_design.identify.outcome import Check
from hfc_design.identify.parameters import LATE, Free
from hfc_design.identify.recording import Recording
from hfc_design.identify.replay import Residual, loop, replay
from hfc_design.identify.request import Task, looked_for
from hfc_design.identify.response import response
from hfc_design.identify.result import Identified
from hfc_design.identify.tables import response_lines

#: A residual above this share of the motion is no replay of it.
LOST = 0.2
#: A second log that is so many times as far off as the first one is not of the same machine.
STRANGE = 4.0
#: A model that takes less than the command in this share of its log is not of this drive.
CLIPPED = 0.1
#: A parameter that only shows where flanks change, for longer than this share of a log on either.
GAP, RARE = "backlash", 0.01
HIDDEN = "the backlash is not seen in this log: a weight keeps one flank; taken as 0, measure it"


def identify(task: Task, logs: dict[str, Recording], tell: Tell = lambda line: None) -> Identified:
    """What the first of ``logs`` tells of the machine of ``task``; the others check it.

    Raises:
        UserError: a parameter is unknown, there is nothing to replay a log with, or no replay
            of it stays finite.
    """
    (name, told), *_ = logs.items()
    wanted = looked_for(task)
    for log, each in logs.items():
        if each.command is None and (task.design is None or each.reference is None):
            why = "has no command; with the reference and --controller DESIGN its loop is replayed"
            raise UserError(f"{log}: {why}")
    own_parts = [("plant", wanted.drive.name), ("plant", task.scenario.plant.name)]
    with own_code(" cannot be replayed", *own_parts):
        found = _found(task, wanted, name, told, tell)
    with about(name):
        _check_slopes(found.fit)
    substeps = task.scenario.simulation.substeps
    known = certainty(found.fit)
    tell("how the fit grows worse beside the best values")
    worst = profiles(found, known)
    tell("what to record next")
    next_one = advice(found, known, told, substeps)
    tell("fitted again without what the log does not tell")
    found, known, states, note = kept(found, known)
    tell("what the parameters do on each log")
    own, (known, apart) = response(found), halved(found, known, states)
    known, states, hidden = unseen_gap(found, known, states, told, substeps)
    if fault_found := fault(found.fit.free, found.fit.numbers):
        told_why = f"is only replayed with what no machine has: {fault_found}"
        raise UserError(f"{name}: {told_why}; look for fewer with --free")
    checks = checked(task, found, logs)
    pushed = task.scenario.machine.forces is not None
    against = *doubts(name, found, known, told, pushed), *strangers(checks, logs)
    said = (note, apart, hidden, *response_lines(own), *against, *told.notes, wanted.rest())
    parts = found, known, states, worst, checks, next_one, own, told
    return Identified(name, task, *parts, tuple(filter(None, said)))


def unseen_gap(
    found: Found, known: Certainty, states: tuple[str, ...], told: Recording, substeps: int
) -> tuple[Certainty, tuple[str, ...], str]:
    """What is known but a backlash from flank to flank of which the log never goes, and a line."""
    fit, seen, names = found.fit, found.fit.free.drive.seen[0], np.array(found.fit.free.names)
    others, here = [name for name in fit.free.drive.encoders if name != seen], names == GAP
    if not here.any() or found.bandwidth is None or not others:
        return known, states, ""
    both = told._replace(outputs={seen: told.place, others[0]: told.place})
    one = replay(fit.free, both, found.bandwidth, substeps)
    off = offs(found.problem._replace(residual=one, scale=np.ones(2)), fit.numbers)
    bent = np.quantile(off[:, 0] - off[:, 1], [RARE, 1.0 - RARE])
    if np.ptp(bent) >= 0.5 * known.value[here]:
        return known, states, ""
    value, low = (np.where(here, 0.0, x) for x in (known.value, known.low))
    known = known._replace(value=value, low=low, told=tuple((~here & known.told).tolist()))
    return known, tuple(np.where(here, "no", states).tolist()), HIDDEN


def _found(task: Task, wanted: Free, name: str, told: Recording, tell: Tell) -> Found:
    with about(name):
        tried = [] if told.command is None else bandwidths(told, task.bandwidth)
    for line in filter(None, [wanted.wanted(), wanted.rest()]):
        tell(line)
    if tried:
        substeps = task.scenario.simulation.substeps
        return by_command(wanted, told, substeps, tried, task.seed, tell)
    assert task.design is not None
    residual = loop(task.scenario, task.design, told)
    return by_starts(wanted, told, residual, None, task.seed, tell)


def _check_slopes(fit: Fit) -> None:
    """ValueError: what was found tells nothing, for it is not finite."""
    if not np.isfinite(fit.rms).all():
        raise ValueError("no parameters were found with which a replay stays finite")
    lost = np.flatnonzero(~np.isfinite(fit.jacobian).all(axis=(0, 1)))
    if lost.size:
        bad = [(*fit.free.names, *LATE)[k] for k in lost]
        raise ValueError(
            f"its replay has no slope by {', '.join(bad)}: look for others with --free, or mend "
            "the plant's step there"
        )


def checked(task: Task, found: Found, logs: dict[str, Recording]) -> tuple[Check, ...]:
    """Every log replayed in every way that there is."""
    checks, scenario, design = list[Check](), task.scenario, task.design
    for name, told in logs.items():
        ways: dict[str, Residual] = {}
        if told.command is not None and found.bandwidth is not None:
            own = replay(found.fit.free, told, found.bandwidth, scenario.simulation.substeps)
            ways[found.how] = own
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
    low, high = drive.largest_commands(fit.free.parts(fit.numbers)[0])
    share = float(np.mean((command < low) | (command > high)))
    if not share:
        return []
    why = "NOT USABLE: the model cannot drive its own log: " * (share > CLIPPED)
    return [
        f"{why}{100 * share:.2g} % of the commands are beyond the {low:.4g} to {high:.4g} "
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
