"""``hfc identify``: a machine's parameters from its log."""

import shlex
import sys
from os.path import isfile
from pathlib import Path
from time import monotonic
from typing import Any

import click

from hfc_design.cli.named import DESIGN, PLANT, SCENARIO, named
from hfc_design.cli.options import PATH, as_json, force, free, setting, with_plugins

COLUMN_HELP = "Which column a signal is, and its unit, as in 'position=qm [m]'; several times."
CHECK_COLUMN_HELP = "The same where --check-log differs."
FREE_HELP = "Parameters to look for, as a,b=START [default: all but exact ones, 0 and --set]."
LOOP_HELP = "The controller in the loop that recorded LOG: its loop is replayed too."
SCENARIO_HELP = "Plant, values to start from, sensors, limits [default: of --controller]."


@click.command(short_help="Find the parameters of a machine from what LOG has recorded.")
@click.argument("log", type=PATH)
@named("--plant", kind=PLANT, help="NAMES, or an own one as module:OBJECT.")
@named("--scenario", kind=SCENARIO, help=SCENARIO_HELP)
@setting
@click.option("--axis", help="Which one, of a machine of several.")
@click.option("--free", "names", help=FREE_HELP)
@named("--controller", kind=DESIGN, help=LOOP_HELP)
@click.option("--open-loop", is_flag=True, help="Replay the plant without an observer.")
@click.option("--bandwidth", type=click.FloatRange(0.0), help="Of the observer [Hz].")
@click.option("--column", "columns", multiple=True, metavar="NAME=COLUMN", help=COLUMN_HELP)
@click.option(
    "--sample-time",
    type=click.FloatRange(0.0, min_open=True),
    help="[s], where LOG does not say it.",
)
@click.option("--check-log", type=PATH, help="Another log, which the result is checked on.")
@click.option(
    "--check-column", "check_columns", multiple=True, metavar="NAME=COLUMN", help=CHECK_COLUMN_HELP
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Of the starts [default: 0].")
@click.option("--out", type=PATH, help="Folder [default: LOG-identified].")
@force
@as_json
@with_plugins({})
def identify(
    log: Path,
    names: str | None,
    open_loop: bool,
    bandwidth: float | None,
    sample_time: float | None,
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
    from hfc_design.cli import identified_tables
    from hfc_design.core.records import UserError
    from hfc_design.identify import aim, asking, page, sources

    if open_loop and bandwidth is not None:
        raise UserError("--open-loop: has no observer; leave out --bandwidth")
    # What is mistyped is told first, then what is in the way; only then anything is read.
    free_ones = [name.strip() for name in names.split(",")] if names else None
    hz = 0.0 if open_loop else bandwidth
    question = asking.asked(log, free=free_ones, bandwidth=hz, **given)
    path = free(out or Path(aim.called(sources.called(log))), folder=True)
    if isfile(path):
        raise UserError(f"--out {path}: is a file, and what is written is a folder")
    begin = monotonic()

    def tell(step: str) -> None:
        click.echo(f"{monotonic() - begin:4.0f} s  {step}", err=True)

    found = asking.answered(question, sample_time, tell)
    page.write(found, path, shlex.join(["hfc", *sys.argv[1:]]))
    identified_tables.tell(found, path, as_json)
