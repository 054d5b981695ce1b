"""Frequency responses of logs and designs, from a script."""

from collections.abc import Sequence
from pathlib import Path

from hfc_design.calls.circling import is_log
from hfc_design.core.arguments import check_positive, check_whole, path_of
from hfc_design.core.overrides import Changes
from hfc_design.core.records import UserError, option
from hfc_design.files.design import AnyDesign
from hfc_design.files.design_set import labelled
from hfc_design.files.loop_setup import own_scenario
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.identify.frequency import measured_response
from hfc_design.identify.recording import recordings, sources
from hfc_design.identify.request import task_of
from hfc_design.simulation.frequency import simulated_response
from hfc_design.simulation.limit_cycles import limit_cycles
from hfc_design.stability.frequency import Frequencies, FrequencyResponse

MOST_MACHINES, MOST_FREQUENCIES = 10_000, 1000


def frequency(
    *logs_and_designs: AnyDesign | str | Path,
    plant: str | None = None,
    scenario: AnyScenario | None = None,
    changes: Changes = (),
    axis: str | None = None,
    columns: Sequence[str] = (),
    sample_time: float | None = None,
    speed: float | None = None,
    amplitudes: Sequence[float] = (),
    machines: int = 200,
    frequencies: int = 40,
    cycles: bool = False,
) -> Frequencies:
    """Return frequency responses of logs and of the simulated loops of designs.

    A log with the command and the position gives the response of the drive, with its coherence and
    modes, and the open loop if a signal was added to the command (column "added"). A design gives
    the response of its non-linear loop to sines of several amplitudes, added to its command while
    the axis moves, and to the load, on the nominal machine and others. The table has crossover,
    phase and gain margin, sensitivity, bandwidth and compliance.

    The counterpart of ``hfc frequency``. The result displays itself as a table and has
    ``numbers()``; ``plot`` draws it.

    Args:
        logs_and_designs: paths of logs (files other than .json), and designs.
        plant: name of the plant of the logs; not needed with a scenario or a design.
        scenario: scenario with machine, sensors and limits; default: that of each design.
        changes: changes to the scenario, by dotted keys.
        axis: name of the axis; default: the first.
        columns: column of a signal of the logs and its unit, as in "position=qm [m]".
        sample_time: sample time of the logs [s], if they do not contain it.
        speed: speed of the axis while sines are added [unit of its position per s]; default: the
            highest of the scenario's motions.
        amplitudes: amplitude of the sines on the command [its unit], of several the machines get
            the middle one, the nominal machine all; default: 1, 3 and 10 % of the largest command.
        machines: number of machines within the tolerances of the scenario, beside the nominal one.
        frequencies: number of frequencies, evenly on a logarithmic scale.
        cycles: predict limit cycles of the designs at rest, and simulate them.

    Raises:
        UserError: a log cannot be read, is not coherent or lacks a signal; a design does not exist
            or does not fit the scenario; or a number is not allowed.
    """
    check_whole("machines", machines, 0, MOST_MACHINES)
    check_whole("frequencies", frequencies, 2, MOST_FREQUENCIES)
    for amplitude in amplitudes:
        check_positive("amplitude", amplitude, argument="amplitudes")
    if not logs_and_designs:
        raise UserError("a log or a design is missing")
    logs = [x for x in logs_and_designs if is_log(x)]
    designs = [x for x in logs_and_designs if not is_log(x)]
    if cycles and not designs:
        raise UserError(f"{option('cycles', argument='cycles')}: needs a design")
    responses, oscillations = list[FrequencyResponse](), []
    for log in logs:
        known = designs[0] if designs else None
        task = task_of(plant, scenario, changes, axis, known, None, None, 0)
        task, read = recordings(task, sources(task, path_of(log), columns, None, ()), sample_time)
        for name, recording in read.items():
            responses.append(measured_response(recording, task.drive_axis.drive, name))
    for label, design in (labelled(designs) if designs else {}).items():
        about = (axis, speed, amplitudes, machines, frequencies)
        where = load_scenario(scenario or own_scenario(design, design.name), changes)
        for one in simulated_response(design, where, *about):
            responses.append(one._replace(source=one.source.replace(design.name, label, 1)))
        oscillations += limit_cycles(design, where, axis) if cycles else []
    return Frequencies(responses, oscillations if cycles else None)
