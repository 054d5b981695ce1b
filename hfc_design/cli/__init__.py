"""The command line. Commands import what they need when they run, so that help is quick."""

import sys
import threading

import click

from hfc_design import __version__
from hfc_design.cli.attaining import attainable
from hfc_design.cli.comparing import compare
from hfc_design.cli.designing import design
from hfc_design.cli.exchange import export, import_
from hfc_design.cli.identifying import identify
from hfc_design.cli.insight import explain, list_, stability
from hfc_design.cli.showing import show
from hfc_design.cli.simulating import batch, report, score, simulate
from hfc_design.cli.starting import init
from hfc_design.cli.trading import pick
from hfc_design.cli.training import train

#: In the order in which a user meets them.
COMMANDS = (
    *(list_, show, init, design, pick, score, compare, simulate, train, identify, export, import_),
    *(explain, stability, attainable, report, batch),
)
SETTINGS = {"help_option_names": ["-h", "--help"]}


class Commands(click.Group):
    """A group whose commands tell a user's mistake in one line."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names as they were added, not by the alphabet."""
        return list(self.commands)

    def invoke(self, ctx: click.Context) -> object:
        """Run a command; UserError becomes a line on stderr and its exit code."""
        from hfc_design.core.interrupt import heard, listen
        from hfc_design.core.records import LONGEST, RunError, UserError, in_a_line

        if threading.current_thread() is threading.main_thread():  # others cannot
            listen()
        try:
            return super().invoke(ctx)
        except UserError as error:
            click.echo(f"hfc: {error}", err=True)
            sys.exit(error.exit_code)
        except click.UsageError as error:
            if len(message := error.format_message()) <= LONGEST:
                raise
            raise click.UsageError(in_a_line(message), error.ctx) from None
        except BrokenPipeError:
            sys.exit(1)
        except OSError as error:  # such as a name that no file can have
            told = RunError(f"{error.filename}: {error.strerror}" if error.filename else str(error))
            click.echo(f"hfc: {told}", err=True)
            sys.exit(told.exit_code)
        except Exception:
            heard()  # a library that is interrupted while it is imported may tell something else
            raise


@click.group(cls=Commands, commands=COMMANDS, context_settings=SETTINGS)
@click.version_option(__version__, prog_name="hfc")
def main() -> None:
    """Design hierarchical fuzzy controllers for machine-tool drives by simulation."""
