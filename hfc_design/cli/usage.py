"""Mistakes on a command line, reported in a line each with the correct usage."""

import os
import re
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from io import TextIOWrapper
from typing import Any

import click

#: Key in ``meta`` of a context, for the typed value of each parameter of the command.
TYPED = "hfc.typed"
#: Metavar of an option that takes a key and its value.
KEYED = re.compile(r"[A-Z]+=[A-Z]+")
NUMBERS = click.types.IntParamType, click.types.FloatParamType


class Refusing(click.Command):
    """A command that reports a user's mistake in a line and exits."""

    def main(self, *arguments: Any, **options: Any) -> Any:
        """Run it; a terminal shows "?" for what its code page lacks, a file or pipe gets UTF-8."""
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):
                same = stream.isatty() or "PYTHONIOENCODING" in os.environ
                stream.reconfigure(encoding=stream.encoding if same else "utf-8", errors="replace")
        return super().main(*arguments, **options)

    def make_context(self, *arguments: Any, **options: Any) -> click.Context:
        """Parse the arguments; a mistake becomes a line on stderr and an exit code."""
        with as_lines():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; a UserError becomes lines on stderr and its exit code."""
        with as_lines():
            return super().invoke(ctx)


class Plain(Refusing):
    """A ``Refusing`` command that rejects repeated options: one of hfc, or of another script."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Check and parse the parameters."""
        if not ctx.resilient_parsing:  # true if a shell asks for completions
            check_once(ctx, args)
        return super().parse_args(ctx, args)


def refusal(text: str) -> Exception:
    """Return a UserError with this line; its class is imported late, so that help is quick."""
    from hfc_design.core.records import UserError

    return UserError(text)


@contextmanager
def as_lines() -> Iterator[None]:
    """Turn a user's mistakes into lines on stderr and an exit code."""
    try:
        yield
    except (click.exceptions.Exit, click.Abort, click.exceptions.NoArgsIsHelpError):
        raise
    except BrokenPipeError:
        sys.exit(1)
    except Exception as error:
        _tell(error)
        raise


def _tell(error: Exception) -> None:
    """Exit with lines for the user, unless ``error`` is a fault of the program."""
    from hfc_design.core.interrupt import heard  # late, so that help is quick
    from hfc_design.core.records import RunError, UserError

    if isinstance(error, click.UsageError):
        error = UserError(_line(error))
    elif isinstance(error, OSError):  # such as a name that no file can have
        named = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        error = RunError(named)
    if isinstance(error, UserError):
        for line in error.lines:
            click.echo(f"hfc: {line}", err=True)
        sys.exit(error.exit_code)
    heard()  # a library that Ctrl-C interrupts during its import may raise another error


def check_once(ctx: click.Context, arguments: list[str]) -> None:
    """Check that no option with one value and no KEY=VALUE is repeated, and that numbers are plain.

    Of repeated values click would take only the last one, without a message.

    Raises:
        click.UsageError, UserError: one is repeated, or the arguments cannot be read.
    """
    try:
        typed, _, order = ctx.command.make_parser(ctx).parse_args([*arguments])
    except click.UsageError as error:
        error.ctx = error.ctx or ctx
        raise
    ctx.meta[TYPED] = typed
    for option, times in Counter(order).items():
        if not isinstance(option, click.Option):
            continue
        name, values = option.opts[0], typed[option.name]
        if times > 1 and not (option.multiple or option.is_flag):
            raise click.UsageError(f"{name} must be given once (got it {times} times)", ctx)
        if isinstance(option.type, NUMBERS) and any(
            "_" in x or not x.isascii() for x in ([values] if isinstance(values, str) else values)
        ):
            raise click.BadParameter("", ctx, option)  # int() and float() would accept it
        if option.multiple and KEYED.fullmatch(option.metavar or ""):
            keys = Counter(text.partition("=")[0].strip() for text in values)
            key, most = keys.most_common(1)[0]
            if most > 1:
                raise refusal(f"{name} {key}: must be given once (got it {most} times)")


def _line(error: click.UsageError) -> str:
    """Return the line on a mistake, with the allowed values."""
    inner = error.ctx is not None and error.ctx.parent is not None
    command = str(error.ctx.info_name) if error.ctx and inner else ""
    if isinstance(error, click.MissingParameter) and error.param is not None:
        name = error.param.make_metavar(error.ctx) if error.ctx else ""
        option = error.param.opts[0] if isinstance(error.param, click.Option) else name
        path = error.ctx.command_path if error.ctx else ""
        return f"{command}: {option} is missing; {path} -h lists the options"
    if isinstance(error, click.BadParameter) and error.param is not None:
        typed = error.ctx.meta.get(TYPED, {}).get(error.param.name) if error.ctx else None
        if isinstance(typed, list):  # of an option that can be given several times
            from hfc_design.core.numbers import NUMBER

            typed = next((text for text in typed if not NUMBER.fullmatch(text)), None)
        name = error.param.opts[0]
        if not isinstance(error.param, click.Option):
            name = error.param.human_readable_name.upper()
        if isinstance(typed, str) and (allowed := _allowed(error.param.type, typed)):
            return f"{name} {typed}: {allowed}"
        return f"{name}: {error.message.rstrip('.')}"
    message = error.format_message().rstrip(".")
    if isinstance(error, click.NoSuchOption):
        from hfc_design.core.wording import alternatives

        near = alternatives(map(repr, error.possibilities or ()))
        message = f"no such option {error.option_name!r}{near and f'; did you mean {near}?'}"
    if not message[1:2].isupper():  # else it begins with a name
        message = message[:1].lower() + message[1:]
    return f"{command}: {message}" if command else message


def _allowed(kind: Any, typed: str) -> str:
    """Return the allowed values of a type of parameter; "" if click's message states them."""
    if isinstance(kind, click.Choice):
        from hfc_design.core.wording import one_of

        return f"unknown value; {one_of(typed, map(str, kind.choices))}"
    if not isinstance(kind, NUMBERS):
        return ""
    whole = isinstance(kind, click.types.IntParamType)
    number = "must be a whole number" if whole else "must be a number"
    low, high = getattr(kind, "min", None), getattr(kind, "max", None)
    if low is None:
        return number
    return f"{number} of at least {low}" if high is None else f"{number} from {low} to {high}"
