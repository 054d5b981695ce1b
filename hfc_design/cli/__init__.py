"""The command line. Commands import what they need when they run, so that help is quick."""

import os
import re
import threading
from typing import Any

import click

from hfc_design import __version__
from hfc_design.cli.circling import circle
from hfc_design.cli.comparing import compare
from hfc_design.cli.designing import design
from hfc_design.cli.exchange import export, import_
from hfc_design.cli.identifying import check, experiment, frequency, identify, laps
from hfc_design.cli.insight import attainable, explain, stability
from hfc_design.cli.plotting import plot
from hfc_design.cli.reporting import report
from hfc_design.cli.showing import init, list_, show
from hfc_design.cli.simulating import batch, score, simulate, train
from hfc_design.cli.trading import pick
from hfc_design.cli.usage import Refusing, as_lines, refusal

#: Commands in the order in which a user meets them.
COMMANDS = (
    *(list_, show, init, design, pick, score, compare, simulate, train, experiment, identify),
    *(frequency, check, laps, export, import_, circle, explain, plot, stability, attainable),
    *(report, batch),
)
SETTINGS = {"help_option_names": ["-h", "--help"]}


class Commands(Refusing, click.Group):
    """A group whose commands report a user's mistake in one line."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of their addition, not in alphabetical order."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Every command with its summary, or the first sentence of its help, untruncated."""
        rows = [(name, summary(command)) for name, command in self.commands.items()]
        with formatter.section("Commands"):
            formatter.write_dl(rows)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the named command; UserError: it does not exist."""
        from hfc_design.core.wording import one_of

        if args[0] not in self.commands and not args[0].startswith("-"):
            raise refusal(f"{args[0]}: no such command; {one_of(args[0], self.commands)}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command in an environment that suits JAX; an interrupt ends the command."""
        from hfc_design.core.interrupt import listen

        if threading.current_thread() is threading.main_thread():  # others cannot handle signals
            listen()
        with as_lines():
            check_environment()
        return super().invoke(ctx)


def check_environment() -> None:
    """Refuse environments in which JAX would fail with a traceback; set matplotlib to files only.

    Raises:
        UserError: a variable has an invalid value.
    """
    os.environ["MPLBACKEND"] = "agg"
    name = "JAX_NUM_CPU_DEVICES"
    if not re.fullmatch(r"-1|[1-9][0-9]{0,2}", value := os.environ.get(name, "-1")):
        raise refusal(f"{name}={value}: must be a number of devices, 1 to 999")


def summary(command: click.Command) -> str:
    """Summary of a command in a line or two: the first sentence of its help."""
    first = " ".join((command.help or "").split("\n\n")[0].split())
    return command.short_help or f"{first.partition('. ')[0].rstrip('.')}."


@click.group(cls=Commands, commands=COMMANDS, context_settings=SETTINGS)
@click.version_option(__version__, prog_name="hfc")
def main() -> None:
    """Design hierarchical fuzzy controllers for machine-tool drives by simulation."""
