"""Commands that read logs of machines: its parameters, its frequency response."""

import shlex
import sys
from functools import partial
from os.path import isfile
from pathlib import Path
from time import monotonic
from typing import Any

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, Texts, argument, command, option
from hfc_design.cli.functions import drawn, function
from hfc_design.cli.names import DESIGN
from hfc_design.cli.usage import refusal

CHECKED = option(None, "--check-column", metavar="NAME=COLUMN")
PROMISED = option(None, kind=DESIGN, required=True)


@command(last=common.plugins({}))
def identify(
    call: partial[Any] = function(
        "calls.identifying.identify", "folder", "on_step", check_columns=CHECKED
    ),
    open_loop: bool = option("Replay the plant without an observer."),
    out: Path | None = common.output("Folder [default: LOG-identified].", folder=True),
) -> Answer:
    """Identify the parameters of a machine from the recording LOG."""
    from hfc_design.identify import page
    from hfc_design.identify.recording import log_name
    from hfc_design.identify.scenario import scenario_name

    if open_loop and call.keywords["bandwidth"] is not None:
        raise refusal("--open-loop: uses no observer; leave out --bandwidth")
    path = out or common.free(Path(scenario_name(log_name(call.keywords["log"]))), folder=True)
    if isfile(path):
        raise refusal(f"--out {path}: must be a folder (got a file)")
    begin = monotonic()

    def tell(step: str) -> None:
        click.echo(f"{monotonic() - begin:4.0f} s  {step}", err=True)

    result = call(on_step=tell, **({"bandwidth": 0.0} if open_loop else {}))
    page.write(result, path, shlex.join(["hfc", *sys.argv[1:]]))
    return Answer(result.numbers(), result.tables, [path], indent=1)


@command(last=common.plugins({}))
def frequency(
    sources: Texts = argument(DESIGN, nargs=-1, required=True, metavar="SOURCES"),
    call: partial[Any] = function(
        "calls.frequency.frequency", amplitudes=option(None, "--amplitude")
    ),
    plot: Path | None = common.output("Draw the responses (png, svg or pdf)."),
) -> Answer:
    """Frequency responses of SOURCES, which are logs and designs."""
    return drawn(call(*sources), plot)


@command(last=common.plugins({}))
def experiment(
    call: partial[Any] = function("calls.identifying.experiment", "folder", "how"),
    out: Path | None = common.output("Folder [default: SCENARIO-experiment].", folder=True),
) -> Answer:
    """Make an experiment that tells most of a machine's parameters."""
    from hfc_design.identify.experiment_files import tables

    name = Path(call.keywords["scenario"]).stem
    path = out or common.free(Path(f"{name}-experiment"), folder=True)
    made = call(folder=path, how=shlex.join(["hfc", *sys.argv[1:]]))
    return Answer(made.numbers(), lambda: tables(made), [path], indent=1)


@command(last=common.plugins({}))
def check(
    call: partial[Any] = function("calls.identifying.check", design=PROMISED),
    plot: Path | None = common.output("Draw log and machines (png, svg or pdf)."),
) -> Answer:
    """Whether a machine does what its design promised."""
    return drawn(call(), plot)


@command(last=common.plugins({}))
def laps(
    design: str = argument(DESIGN),
    logs: Texts = argument(nargs=-1, metavar="[LOGS]..."),
    call: partial[Any] = function("calls.laps.laps", "design", "progress"),
    out: Path | None = common.output("Write the table into a folder.", folder=True),
    plot: Path | None = common.output("Draw errors and table (png, svg or pdf)."),
) -> Answer:
    """Laps that learn: a table that is added to the commands of DESIGN."""
    from hfc_design.core.console import MachinesBar

    with MachinesBar() as bar:
        result = call(design, *logs, progress=partial(bar.chunk, "simulating"))
    answer = drawn(result, plot)
    if out is not None:
        result.write(out)
    return answer._replace(files=[*answer.files, *filter(None, [out])])
