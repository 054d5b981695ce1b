"""``hfc identify``: a machine's parameters from its log."""

import json
import shlex
import sys
from os.path import isfile
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli import options as common

if TYPE_CHECKING:
    from hfc_design.identify.result import Identified

COLUMN_HELP = "Which column a signal is, and its unit, as in 'position=qm [m]'; several times."
POSITIVE = click.FloatRange(0.0, min_open=True)
CHECK_HELP = "The same where --check-log differs."
FREE_HELP = "Parameters to look for, as a,b=START [default: all but exact ones, 0 and --set]."
LOOP_HELP = "The controller in the loop that recorded LOG: its loop is replayed too."
SCENARIO_HELP = "Plant, values to start from, sensors, limits [default: of --controller]."


@click.command(short_help="Find the parameters of a machine from what LOG has recorded.")
@click.argument("log", type=common.PATH)
@common.named("--plant", kind=common.PLANT, help="NAMES, or an own one as module:OBJECT.")
@common.named("--scenario", kind=common.SCENARIO, help=SCENARIO_HELP)
@common.setting
@click.option("--axis", help="Which one, of a machine of several.")
@click.option("--free", "names", help=FREE_HELP)
@common.named("--controller", kind=common.DESIGN, help=LOOP_HELP)
@click.option("--open-loop", is_flag=True, help="Replay the plant without an observer.")
@click.option("--bandwidth", type=click.FloatRange(0.0), help="Of the observer [Hz].")
@click.option("--column", "columns", multiple=True, metavar="NAME=COLUMN", help=COLUMN_HELP)
@click.option("--sample-time", type=POSITIVE, help="[s], where LOG does not say it.")
@click.option("--check-log", type=common.PATH, help="Another log, which the result is checked on.")
@click.option("--check-column", "checks", multiple=True, metavar="NAME=COLUMN", help=CHECK_HELP)
@click.option("--seed", type=click.IntRange(0), default=0, help="Of the starts [default: 0].")
@click.option("--out", type=common.PATH, help="Folder [default: LOG-identified].")
@common.force
@common.as_json
@common.with_plugins({})
def identify(
    log: Path,
    names: str | None,
    open_loop: bool,
    bandwidth: float | None,
    sample_time: float | None,
    columns: tuple[str, ...],
    check_log: Path | None,
    checks: tuple[str, ...],
    out: Path | None,
    as_json: bool,
    **given: Any,
) -> None:
    """Find the parameters of a machine that make it do what LOG has recorded.

    LOG is a CSV file with a header, what LinuxCNC's halscope or halsampler write, a .mat of MATLAB
    up to version 7, .npy or .npz. It needs the position and the command, or, with --controller, the
    position and the reference. The plant is simulated under the recorded command from a hundred
    starts, which takes some seconds to a minute; the folder gets report.html, identified.json,
    and scenario.toml, which hfc design takes.
    """
    from hfc_design.core.records import UserError
    from hfc_design.identify import identified, page, recording, scenario
    from hfc_design.identify.request import task_of

    if open_loop and bandwidth is not None:
        raise UserError("--open-loop: has no observer; leave out --bandwidth")
    # What is mistyped is told first, then what is in the way; only then anything is read.
    free_ones = [name.strip() for name in names.split(",")] if names else None
    hz = 0.0 if open_loop else bandwidth
    task = task_of(free=free_ones, bandwidth=hz, **given)
    logs = recording.sources(task, log, columns, check_log, checks)
    path = common.free(out or Path(scenario.scenario_name(recording.log_name(log))), folder=True)
    if isfile(path):
        raise UserError(f"--out {path}: is a file, and what is written is a folder")
    begin = monotonic()

    def tell(step: str) -> None:
        click.echo(f"{monotonic() - begin:4.0f} s  {step}", err=True)

    found = identified.identify(*recording.recordings(task, logs, sample_time), tell)
    page.write(found, path, shlex.join(["hfc", *sys.argv[1:]]))
    if as_json:
        click.echo(json.dumps(found.numbers(), indent=1))
    else:
        _show(found)
        click.echo(path)


def _show(found: "Identified") -> None:
    from hfc_design.core.console import show_rows
    from hfc_design.identify.outcome import CHECKED, HEADS

    parameters = HEADS, found.parameter_rows(), found.interval_line()
    checks = CHECKED, found.check_rows(), ""
    for heads, rows, below in (parameters, checks):
        show_rows(heads, ([_plain(cell) for cell in row] for row in rows), 2, (0, 1))
        click.echo(f"{below}\n" if below else "")
    for line in (found.agreeing_line(), *found.untold_lines(), *found.notes):
        click.echo(line)
    if line := found.advice_line():
        click.echo(f"record next: {_plain(line)}")


def _plain(text: str) -> str:
    """With signs that every terminal has."""
    return text.replace("–", "-").replace("µ", "u").replace("±", "+-")
