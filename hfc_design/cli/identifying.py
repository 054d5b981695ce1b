"""Commands that read logs of machines: its parameters, its frequency response."""

import shlex
import sys
from os.path import isfile
from pathlib import Path
from time import monotonic

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import PATH, Answer, Texts, argument, command, option
from hfc_design.cli.names import DESIGN, PLANT, SCENARIO
from hfc_design.cli.usage import refusal

COLUMN_HELP = (
    "Column of a signal, its unit and where it wraps around, as in 'position=qm [m]' or "
    "'position=phi [deg] mod 720'; can be given several times."
)
FREE_HELP = (
    "Parameters to identify, as a,b=START [default: all except exact ones, zeros and --set]."
)
TIME_HELP = "Sample time [s], if LOG does not contain it."
LOOP_HELP = "The controller of the loop that recorded LOG, to replay the closed loop too."
SCENARIO_HELP = "Plant, start values, sensors, limits [default: those of --controller]."


@command("Identify the parameters of a machine from the recording LOG.", last=common.plugins({}))
def identify(
    log: Path = argument(PATH),
    plant: str | None = option("NAMES, or your own as module:OBJECT.", kind=PLANT),
    scenario: str | None = option(SCENARIO_HELP, kind=SCENARIO),
    changes: Texts = common.SETTING,
    axis: str | None = option("Axis, of a machine with several."),
    free: str | None = option(FREE_HELP),
    controller: str | None = option(LOOP_HELP, kind=DESIGN),
    open_loop: bool = option("Replay the plant without an observer."),
    bandwidth: float | None = option("Bandwidth of the observer [Hz].", low=0.0),
    columns: Texts = option(COLUMN_HELP, "--column", metavar="NAME=COLUMN"),
    sample_time: float | None = option(TIME_HELP, low=0.0, open=True),
    check_log: Path | None = option("Another log, to check the result."),
    checks: Texts = option(
        "The same for --check-log, where it differs.", "--check-column", metavar="NAME=COLUMN"
    ),
    seed: int = option("Random seed of the starts [default: 0].", low=0, default=0),
    out: Path | None = option("Folder [default: LOG-identified]."),
    _force: bool = common.FORCE,
    _as_json: bool = common.AS_JSON,
) -> Answer:
    """Identify the parameters with which a simulated machine reproduces the recording LOG.

    LOG is a CSV file with a header, the output of LinuxCNC's halscope or halsampler, a .mat file up
    to MATLAB 7, .npy or .npz. It needs the position and the command, or, with --controller, the
    position and the reference. The plant is simulated under the recorded command from a hundred
    starts, which takes some seconds to a minute; the folder gets report.html, identified.json, and
    scenario.toml for hfc design.
    """
    from hfc_design.calls import identifying as calls
    from hfc_design.identify import page
    from hfc_design.identify.recording import log_name
    from hfc_design.identify.scenario import scenario_name

    if open_loop and bandwidth is not None:
        raise refusal("--open-loop: uses no observer; leave out --bandwidth")
    path = common.free(out or Path(scenario_name(log_name(log))), folder=True)
    if isfile(path):
        raise refusal(f"--out {path}: must be a folder (got a file)")
    begin = monotonic()

    def tell(step: str) -> None:
        click.echo(f"{monotonic() - begin:4.0f} s  {step}", err=True)

    result = calls.identify(
        log,
        plant,
        scenario=scenario,
        changes=changes,
        axis=axis,
        controller=controller,
        free=[name.strip() for name in free.split(",")] if free else None,
        bandwidth=0.0 if open_loop else bandwidth,
        columns=columns,
        sample_time=sample_time,
        check_log=check_log,
        check_columns=checks,
        seed=seed,
        on_step=tell,
    )
    page.write(result, path, shlex.join(["hfc", *sys.argv[1:]]))
    return Answer(result.numbers(), result.tables, [path], indent=1)


@command("Frequency response of a log, or of a design's loop.", last=common.plugins({}))
def frequency(
    sources: Texts = argument(PATH, nargs=-1, required=True, metavar="SOURCES"),
    plant: str | None = option("Plant of the logs [default: that of a design].", kind=PLANT),
    scenario: str | None = option("Machine, sensors, limits, tolerances.", kind=SCENARIO),
    changes: Texts = common.SETTING,
    axis: str | None = option("Axis, of a machine with several [default: the first]."),
    columns: Texts = option(COLUMN_HELP, "--column", metavar="NAME=COLUMN"),
    sample_time: float | None = option(TIME_HELP, low=0.0, open=True),
    speed: float | None = option("Speed of the axis while sines are added, in its unit per s."),
    amplitudes: tuple[float, ...] = option(
        "Amplitude of the sines, in the unit of the command; can be given several times "
        "[default: 1, 3 and 10 % of the largest command].",
        "--amplitude",
        kind=click.FLOAT,
        multiple=True,
    ),
    machines: int = option("Machines beside the nominal one [default: 200].", default=200),
    frequencies: int = option("Number of frequencies [default: 40].", default=40),
    cycles: bool = option("Predict limit cycles at rest, and simulate them."),
    plot: Path | None = common.output("Draw the responses (png, svg or pdf)."),
    _force: bool = common.FORCE,
    _as_json: bool = common.AS_JSON,
) -> Answer:
    """Frequency response of logs and of designs' loops, over one another.

    SOURCES are logs and designs. A log with the command and the position gives the response of the
    drive with its coherence and its modes; if a signal was added to the command (column "added"),
    also the open loop. A design is simulated: sines of several amplitudes are added to its command
    while the axis moves, and to the load, on the nominal machine and others. The table has
    crossover, phase and gain margin, sensitivity, bandwidth and compliance.
    """
    from hfc_design.calls import frequency as calls

    result = calls.frequency(
        *map(str, sources),
        plant=plant,
        scenario=scenario,
        changes=changes,
        axis=axis,
        columns=columns,
        sample_time=sample_time,
        speed=speed,
        amplitudes=amplitudes,
        machines=machines,
        frequencies=frequencies,
        cycles=cycles,
    )
    if plot is not None:
        from hfc_design.plotting.files import save

        save(result.figure(), plot)
    return Answer(result.numbers(), result.tables, [plot] if plot else [])


@command("Make an experiment that tells most of a machine's parameters.", last=common.plugins({}))
def experiment(
    scenario: str = argument(SCENARIO),
    changes: Texts = common.SETTING,
    axis: str | None = option("Axis, of a machine with several [default: the first]."),
    parameters: str | None = option("Parameters to show, as a,b [default: all]."),
    duration: float = option("Duration [s] [default: 20].", default=20.0),
    travel: float | None = option("Travel from end to end [default: of the scenario's motions]."),
    speed: float | None = option("Largest speed [default: of the scenario's motions]."),
    acceleration: float | None = option("Largest acceleration [default: of these motions]."),
    limit: float | None = option("Largest command [default: the limit of SCENARIO].", "--command"),
    add: bool = option("Add signals to the command too, which shows modes better."),
    controller: str | None = option("Design that follows the reference.", kind=DESIGN),
    out: Path | None = option("Folder [default: SCENARIO-experiment]."),
    _force: bool = common.FORCE,
    _as_json: bool = common.AS_JSON,
) -> Answer:
    """Make the experiment that tells most of a machine's parameters, inside its limits.

    Moves to and fro at several speeds, sines and, with --add, signals on the command are simulated
    on machines within the tolerances of SCENARIO. Those that add most Fisher information are taken,
    and made smaller until no machine of a thousand exceeds a limit. The folder gets a page that
    says what to connect and to record, and the experiment as CSV, G-code, C array and for HAL.
    """
    from hfc_design.calls import identifying as calls
    from hfc_design.identify.experiment_files import tables

    path = common.free(out or Path(f"{Path(scenario).stem}-experiment"), folder=True)
    made = calls.experiment(
        scenario,
        axis=axis,
        parameters=[name.strip() for name in parameters.split(",")] if parameters else None,
        duration=duration,
        travel=travel,
        speed=speed,
        acceleration=acceleration,
        command=limit,
        add=add,
        controller=controller,
        changes=changes,
        folder=path,
        how=shlex.join(["hfc", *sys.argv[1:]]),
    )
    return Answer(made.numbers(), lambda: tables(made), [path], indent=1)


@command("Whether a machine does what its design promised.", last=common.plugins({}))
def check(
    log: Path = argument(PATH),
    design: str | None = option("Design that controlled the machine.", kind=DESIGN, required=True),
    scenario: str | None = option(SCENARIO_HELP, kind=SCENARIO),
    changes: Texts = common.SETTING,
    axis: str | None = option("Axis, of a machine with several."),
    machines: int = option("Machines within the tolerances [default: 1000].", default=1000),
    columns: Texts = option(COLUMN_HELP, "--column", metavar="NAME=COLUMN"),
    sample_time: float | None = option(TIME_HELP, low=0.0, open=True),
    plot: Path | None = common.output("Draw log and machines (png, svg or pdf)."),
    _force: bool = common.FORCE,
    _as_json: bool = common.AS_JSON,
) -> Answer:
    """Whether the machine of a recording LOG does what its design promised, and if not, why.

    A thousand machines within the tolerances follow the reference of LOG. The answer is a p-value,
    the numbers of the loop beside those of the machines and, if the machine is unlike them, which
    change explains the log best: friction, backlash, delay or another parameter, and by how much.
    """
    from hfc_design.calls import identifying as calls

    result = calls.check(
        log,
        design or "",
        scenario=scenario,
        axis=axis,
        machines=machines,
        columns=columns,
        sample_time=sample_time,
        changes=changes,
    )
    if plot is not None:
        from hfc_design.plotting.files import save

        save(result.figure(), plot)
    return Answer(result.numbers(), result.tables, [plot] if plot else [])
