"""Identification of a machine from its log, and the experiment for it, from a script."""

import shlex
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from hfc_design.core.arguments import check_positive, check_whole, path_of
from hfc_design.core.overrides import Changes, overridden
from hfc_design.core.records import UserError
from hfc_design.core.wording import percent, three_digits
from hfc_design.files.design import AnyDesign
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify import experiment_files, identified
from hfc_design.identify.checking import LATER, Check, Promise
from hfc_design.identify.experiment import CHECKED, Experiment, choose, follower
from hfc_design.identify.frequency import measured_response
from hfc_design.identify.identified import Identified
from hfc_design.identify.page import write
from hfc_design.identify.recording import Recording, recordings, sources
from hfc_design.identify.request import task_of
from hfc_design.simulation.frequency import Setup
from hfc_design.simulation.usable import usable
from hfc_design.stability.frequency import COLUMNS
from plants import Drive

#: Relative difference of sample times that counts as none.
SAME_PERIOD = 1e-3
#: Machines on which a design is tested again after a change.
AGAIN = 200


def identify(
    log: str | Path,
    plant: str | None = None,
    *,
    scenario: AnyScenario | None = None,
    changes: Changes = (),
    axis: str | None = None,
    controller: AnyDesign | None = None,
    free: Sequence[str] | None = None,
    bandwidth: float | None = None,
    columns: Sequence[str] = (),
    sample_time: float | None = None,
    check_log: str | Path | None = None,
    check_columns: Sequence[str] = (),
    seed: int = 0,
    folder: str | Path | None = None,
    on_step: Callable[[str], None] = lambda line: None,
) -> Identified:
    """Find the parameters with which a simulated machine reproduces a recorded log.

    The plant is simulated under the recorded command from a hundred starts, which takes some
    seconds to a minute. A folder gets report.html, identified.json, and scenario.toml for a search.

    The counterpart of ``hfc identify``. The result displays itself as a table; its ``numbers()``
    are the content of ``identified.json``, its ``for_design()`` is the scenario for a search, and
    ``plot`` draws the replay beside the log.

    Args:
        log: path of the log: CSV with a header, output of LinuxCNC's halscope or halsampler, of
            TwinCAT's Scope or a SINUMERIK trace, MDF, TDMS, HDF5, .mat, .npy or .npz. It needs the
            position and the command, or, with a controller, the position and the reference.
        plant: name of the plant of the machine; not needed with a scenario or a controller.
        scenario: scenario with the plant, the start values, the sensors and the limits; default:
            the scenario of the controller.
        changes: changes to the scenario, by dotted keys. Parameters of the machine, constant load,
            delay and lag count as known if they are set here, and are not identified.
        axis: name of the axis, for a machine of several axes.
        free: parameters to identify, as "mass", or "mass=50" with a start value; default: all that
            are neither exact nor 0 nor in ``changes``, and a constant load if none of them is one.
        controller: controller in the loop that recorded the log; its closed loop is replayed too.
        bandwidth: bandwidth of the observer [Hz]; 0 replays in open loop; default: the best of 50,
            20 and 5 Hz.
        columns: column of a signal, its unit and where it wraps around, as in "position=qm [m]" or
            "position=phi [deg] mod 720".
        sample_time: sample time of the log [s], if the log does not contain it.
        check_log: path of another log on which the result is checked.
        check_columns: the same for ``check_log``, where it differs from ``columns``.
        seed: seed of the random starts.
        folder: folder to which page, numbers and scenario are written; default: nothing is written.
        on_step: function called with a line of text at every step.

    Raises:
        UserError: the machine, the axis or a parameter does not exist; the log cannot be read or
            lacks a needed signal; or no replay of it stays finite.
        RunError: the folder cannot be written.
    """
    check_whole("seed", seed, 0)
    if bandwidth:  # 0: open loop
        check_positive("bandwidth", bandwidth)
    if sample_time is not None:
        check_positive("sample_time", sample_time)
    place = None if folder is None else path_of(folder)
    other = None if check_log is None else path_of(check_log)
    task = task_of(plant, scenario, changes, axis, controller, free, bandwidth, seed)
    logs = sources(task, path_of(log), columns, other, check_columns)
    result = identified.identify(*recordings(task, logs, sample_time), on_step)
    if place is not None:
        write(result, place, "hfc_design.api.identify")
    return result


def experiment(
    scenario: AnyScenario,
    *,
    axis: str | None = None,
    parameters: Sequence[str] | None = None,
    duration: float = 20.0,
    travel: float | None = None,
    speed: float | None = None,
    acceleration: float | None = None,
    command: float | None = None,
    add: bool = False,
    controller: AnyDesign | None = None,
    changes: Changes = (),
    folder: str | Path | None = None,
    how: str = "hfc_design.api.experiment",
) -> Experiment:
    """Make the experiment that tells most of a machine's parameters, inside its limits.

    Moves to and fro at several speeds and sines are simulated on machines within the tolerances of
    the scenario. Those that add most Fisher information are taken, and made smaller until no
    machine of a thousand exceeds a limit. A folder gets a page that says what to connect and to
    record, and the experiment as CSV, G-code, C array and for HAL.

    The counterpart of ``hfc experiment``.

    Args:
        scenario: machine, sensors and tolerances.
        axis: name of the axis; default: the first.
        parameters: parameters that the experiment is to show; default: all that are not exact or 0.
        duration: duration of the experiment [s].
        travel: travel from end to end; default: the largest of the scenario's motions.
        speed: largest speed [unit of the position per s]; default: that of machines in the motion.
        acceleration: largest acceleration of the reference [per s2]; default: that which motion or
            path may have, or that for the speed in 0.1 s.
        command: largest command [its unit]; default: its limit.
        add: add signals to the command too, which shows modes better.
        controller: design that follows the reference; default: a calm PID with feed-forward.
        changes: changes to the scenario, by dotted keys.
        folder: folder to which page and files are written; default: nothing is written.
        how: what made the experiment, for the page.

    Raises:
        UserError: axis or parameter do not exist, a number is out of range, or the travel is too
            short for any experiment.
        RunError: the folder cannot be written.
    """
    check_positive("duration", duration)
    loaded = load_scenario(scenario, changes)
    design = follower(loaded) if controller is None else controller
    setup = Setup.of(design, loaded, axis, 0.0, CHECKED - 1)
    each = {"travel": travel, "speed": speed, "acceleration": acceleration, "command": command}
    known = {name: value for name, value in each.items() if value is not None}
    for name, value in known.items():
        check_positive(name, value)
    made = choose(setup, duration, known, parameters, add)
    if folder is not None:
        one = loaded.plant.each()[setup.axis]
        name = "" if isinstance(scenario, Scenario) else shlex.quote(str(scenario))
        names = {"plant": loaded.plant.name, "scenario": name}
        experiment_files.write(made, one, names, path_of(folder), how)
    return made


def check(
    log: str | Path,
    design: AnyDesign,
    *,
    scenario: AnyScenario | None = None,
    axis: str | None = None,
    machines: int = 1000,
    columns: Sequence[str] = (),
    sample_time: float | None = None,
    changes: Changes = (),
    before: str | Path | None = None,
) -> Check:
    """Compare a log of a machine with what its design promised, on machines within the tolerances.

    The simulated machines follow the reference of the log. The result has a p-value, the numbers
    of the loop beside those of the machines and, if the log is unlike them, which change explains
    it best: friction, backlash, delay or another parameter, and by how much.

    The counterpart of ``hfc check``.

    Args:
        log: path of the log; it needs reference, position and command.
        design: design that controlled the machine.
        scenario: machine, sensors and tolerances; default: that the design was made for.
        axis: name of the axis; default: the first.
        machines: number of machines within the tolerances.
        columns: column of a signal and its unit, as in "position=qm [m]".
        sample_time: sample time of the log [s], if the log does not contain it.
        changes: changes to the scenario, by dotted keys.
        before: log of the same reference when the machine was in order, with the same columns: then
            only what has changed since counts, and not what the model lacks.

    Raises:
        UserError: log, design or axis do not exist or do not fit; the log lacks a signal, or has
            another sample time than the design.
    """
    check_whole("machines", machines, 100, 100_000)
    task = task_of(None, scenario, changes, axis, design, None, None, 0)
    first_log = None if before is None else path_of(before)
    task, read = recordings(task, sources(task, path_of(log), columns, first_log, ()), sample_time)
    (name, recording), *others = read.items()
    setup = Setup.of(design, task.scenario, task.drive_axis.name, 0.0, machines, LATER)
    if abs(recording.sample_time / setup.every - 1.0) > SAME_PERIOD:
        raise UserError(
            f"{name}: must be sampled every {setup.every:g} s, as the design "
            f"(got {recording.sample_time:g} s)"
        )
    first = others[0][1] if others else None
    compared = Promise(setup, recording, name).check(recording, name, first)
    compared = compared._replace(margins=_margins(recording, task.drive_axis.drive))
    if not compared.explained or not (keys := compared.explanations[0].keys):
        return compared
    given = task.scenario.model_dump(exclude_unset=True)
    changed = load_scenario(overridden(given, {k: str(x) for k, x in keys.items()}))
    now = usable(design, changed, machines=AGAIN)
    need = "needs no new design" if now.yes else "should be designed again"
    share = f"{percent(float(now.good.mean()))} of {AGAIN} such machines pass"
    usable_now = f'its answer to "can I use it?" is then {now.verdict}'
    return compared._replace(again=f"; with that it {need} ({usable_now}, {share})")


def _margins(log: Recording, drive: Drive) -> str:
    """Return the margins that the log itself shows, in a line; "": it does not show them."""
    with suppress(UserError):  # nothing excites the loop
        response = measured_response(log, drive, "")
        known = {key: float(x[0]) for key, x in response.margins.items() if np.isfinite(x[0])}
        if "sensitivity" in known:
            each = (f"{COLUMNS[key]} {three_digits(x)}" for key, x in known.items())
            return f"the log's own signals show: {', '.join(each)}"
    return ""
