"""``hfc identify``: a machine's parameters from its log."""

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
    sample_time: float | None = option(
        "Sample time [s], if LOG does not contain it.", low=0.0, open=True
    ),
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
