"""Laps that learn, simulated or from logs, from a script."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from hfc_design.core.arguments import check_positive, check_whole, path_of
from hfc_design.core.numbers import Floats
from hfc_design.core.overrides import Changes
from hfc_design.core.records import option
from hfc_design.core.texts import as_user_error
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.logs.places import places
from hfc_design.logs.reading import read_log
from hfc_design.motion.samples import Samples
from hfc_design.report.laps import Laps
from hfc_design.simulation.frequency import Setup
from hfc_design.simulation.laps import Filters, Kept, filters, largest_error, learned, rms_of

MOST_LAPS, MOST_MACHINES = 100, 10_000
#: Largest rms of a log's reference less the scenario's, as a share of the travel.
LIKE = 0.02


def laps(
    design: AnyDesign,
    *logs: str | Path,
    scenario: AnyScenario | None = None,
    changes: Changes = (),
    motion: str | None = None,
    laps: int = 5,
    machines: int = 200,
    columns: Sequence[str] = (),
    sample_time: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Laps:
    """Return what a design learns from laps: a table that is added to its commands.

    The same motion is repeated, and the table is corrected after each lap by the error of the lap
    (norm-optimal iterative learning control). Its filter suits most machines within the tolerances
    of the scenario. Without logs, laps are simulated: the nominal machine and others learn, each
    from its own errors. With logs of a machine, one for each lap so far in their order (the first
    without a table), the result is the table for the next lap.

    The counterpart of ``hfc laps``. The result displays itself; ``numbers()`` are those of
    ``--json``, ``write(folder)`` writes the table as CSV, for C and for LinuxCNC.

    Args:
        design: the controller.
        logs: logs of the laps so far, with reference and position of each axis.
        scenario: scenario with the motion; default: the one that the design was made for.
        changes: changes to the scenario, by dotted keys.
        motion: name of the motion, if the scenario has several; default: the first.
        laps: number of simulated laps that learn.
        machines: number of machines within the tolerances, beside the nominal one.
        columns: column of a signal of the logs and its unit, as in "x=qm [um]"; signals are time,
            and position and reference, or of several axes x, x_reference and so on.
        sample_time: sample time of the logs [s], if they do not contain it.
        progress: called with the numbers of finished and of all machines.

    Raises:
        UserError: a log cannot be read, lacks a signal, or is of another motion; the loop does not
            answer; or a number is not allowed.
    """
    check_whole("laps", laps, 1, MOST_LAPS)
    check_whole("machines", machines, 0, MOST_MACHINES)
    if sample_time is not None:
        check_positive("sample_time", sample_time)
    design = load_design(design)
    where = load_scenario(scenario or own_scenario(design, design.name), changes).motion(motion)
    samples, errors = where.samples(), list[Floats]()
    for log in logs:
        with as_user_error(log):
            errors.append(_error(path_of(log), where, samples, columns, sample_time))
            if any(np.array_equal(errors[-1], one) for one in errors[:-1]):
                raise ValueError("is given twice, or has the signals of another lap")
    own = filters(design, where)
    if errors:
        names = tuple(path_of(log).name for log in logs)
        return Laps(design.name, where, own, names, *_of_errors(np.array(errors), samples, own))
    result = learned(Setup.of(design, where, None, None, machines), own, laps, progress)
    names = (*map(str, range(laps + 1)), "kept")
    shown = (result.rms, result.largest, result.shared, result.table, result.table)
    return Laps(design.name, where, own, names, *shown, result.errors)


def _of_errors(
    errors: Floats, samples: Samples, own: Filters
) -> tuple[Floats, Floats, None, Floats, Floats, tuple[Floats, Floats]]:
    """Return the last fields of ``Laps`` from the errors of logs (laps, axes, steps)."""
    table = np.zeros_like(errors[0])
    kept = Kept.of(table, errors[0])
    table = kept.following(own)
    for error in errors[1:]:
        kept = kept.after(table, error)
        table = kept.following(own)
    rms, largest = rms_of(errors.reshape(len(errors), -1)), largest_error(samples, -errors)
    return rms[:, None], largest[:, None], None, table, kept.table, (errors[0], kept.error)


def _error(
    log: Path,
    scenario: Scenario,
    samples: Samples,
    columns: Sequence[str],
    sample_time: float | None,
) -> Floats:
    """Return the error (axes, steps) of a lap in a log, less what the reference is off the target.

    Raises:
        ValueError: a signal is missing, the log is too short, or it has another reference.
    """
    axes, units = scenario.machine.axes, [one.drive.units["error"] for one in scenario.plant.each()]
    names = [*axes] if len(axes) > 1 else ["position"]
    references = [f"{name}_reference" for name in axes] if len(axes) > 1 else ["reference"]
    wanted = dict(zip([*names, *references], units * 2, strict=True))
    signals = places(read_log(log), columns, wanted | {"time": "s"}, [*wanted])
    count = len(signals[names[0]])
    if sample_time is None and "time" not in signals:
        raise ValueError(f"has no times; {option('sample_time', ...)} gives their distance")
    time = signals["time"] if sample_time is None else sample_time * np.arange(float(count))
    every, steps = scenario.simulation.sample_time_s, len(samples.time)
    grid = np.arange(time[0], time[-1] + 1e-6 * every, every)
    if len(grid) < steps:
        lasts = f"{steps * every:g} s (got {len(grid) * every:.4g} s)"
        raise ValueError(f"must contain the whole motion of {lasts}")
    reference, place = (
        np.array([np.interp(grid, time, signals[name]) for name in some])
        for some in (references, names)
    )
    commanded = np.array([np.asarray(one.reference) for one in samples.axes])
    begin = _aligned(reference, commanded)
    part = slice(begin, begin + steps)
    off = reference[:, part] - commanded
    off -= off.mean(axis=1, keepdims=True)  # the log may count from another place
    unlike = rms_of(off) / np.maximum(np.ptp(commanded, axis=1), 1e-300)
    if unlike.max() > LIKE:
        name = references[int(unlike.argmax())]
        got = f"(it is {100.0 * unlike.max():.2g} % of the travel off)"
        raise ValueError(f"{name}: must be that of the scenario {scenario.name} {got}")
    target = np.array([np.asarray(one.target) for one in samples.axes])
    return reference[:, part] - place[:, part] + target - commanded


def _aligned(reference: Floats, commanded: Floats) -> int:
    """Return the sample of a log where it is most like the reference of the scenario."""
    from scipy.signal import fftconvolve  # takes long to import

    steps = commanded.shape[1]
    total = 0.0
    for logged, wanted in zip(reference, commanded, strict=True):
        values = logged - logged.mean()
        sums = np.cumsum(np.stack([values, values**2]), axis=1)
        sums = np.hstack([np.zeros((2, 1)), sums])
        mean, power = sums[:, steps:] - sums[:, :-steps]
        common = fftconvolve(values, (wanted - wanted.mean())[::-1], "valid")
        total = total + power - mean**2 / steps - 2.0 * common
    return int(np.argmin(total))
