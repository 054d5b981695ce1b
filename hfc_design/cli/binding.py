"""Makes a command of a function: its parameters are the arguments and options.

A parameter says its type, and as its default what the command line has beside that::

    @command("Draw a picture.")
    def draw(name: str = argument(DESIGN), width: float | None = option("Width [mm].")) -> None:

One whose name begins with ``_`` works by its callback alone; the function does not get it.
"""

import inspect
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_args

import click

from hfc_design.cli.names import Named, NamedOption
from hfc_design.cli.usage import Plain

Texts = tuple[str, ...]
PATH = click.Path(path_type=Path)


class Parameter(NamedTuple):
    """What an argument or option is, but for its name and type."""

    make: type[click.Parameter]
    names: tuple[str, ...]  # of an option on the command line; none: that of the parameter
    kind: Any  # click's type; None: that of the annotation
    settings: dict[str, Any]

    def of(self, name: str, annotation: Any) -> click.Parameter:
        """The parameter of a function that has a name and an annotation, as click has it."""
        settings = {"expose_value": not name.startswith("_"), **self.settings}
        types = [one for one in get_args(annotation) if one is not type(None)] or [annotation]
        plain = str if annotation == Texts else PATH if types[0] is Path else types[0]
        if "low" in settings:
            within = click.IntRange if plain is int else click.FloatRange
            plain = within(settings.pop("low"), min_open=settings.pop("open", False))
        if plain is bool:
            settings.setdefault("is_flag", True)
        elif "is_flag" not in settings:
            settings["type"] = self.kind or plain
        if self.make is click.Argument:
            return click.Argument([name], **settings)
        if isinstance(self.kind, Named):
            settings.setdefault("metavar", "NAME")
        names = self.names or (f"--{name.strip('_').replace('_', '-')}",)
        settings.setdefault("multiple", annotation == Texts)
        return self.make([*names, name], **settings)


class Together(NamedTuple):
    """The default of a parameter whose value ``make`` makes of parameters of its own."""

    make: Callable[..., Any]


def argument(kind: Any = None, **settings: Any) -> Any:
    """What stands in a command line without a name, of click's ``settings``."""
    return Parameter(click.Argument, (), kind, settings)


def option(text: str | None, *names: str, kind: Any = None, **settings: Any) -> Any:
    """An option with its help; ``low`` is the least number, or ``open`` below all; click's rest."""
    return Parameter(NamedOption, names, kind, {"help": text, **settings})


class Answer(NamedTuple):
    """What a command has found."""

    numbers: Any  # what --json prints
    show: Callable[[], object]  # prints it for a person
    files: Sequence[Path] = ()  # that are written
    indent: int | None = None  # of the JSON

    def print(self, as_json: bool) -> None:
        """One face of it on stdout."""
        if as_json:
            click.echo(json.dumps(self.numbers, indent=self.indent))
            return
        self.show()
        for path in self.files:
            click.echo(path)


#: Where a context keeps whether --json is given.
AS_JSON = "hfc.json"


def command(
    short: str | None = None, name: str | None = None, last: Iterable[click.Parameter] = ()
) -> Callable[[Callable[..., Answer | None]], click.Command]:
    """Makes a command of a function whose docstring is the help; ``short`` stands in a list.

    The ``last`` parameters come behind those of the function, which does not get them.
    """

    def bound(function: Callable[..., Answer | None]) -> click.Command:
        def call(**given: Any) -> None:
            if answer := _called(function, given):
                answer.print(click.get_current_context().meta[AS_JSON])

        return Plain(
            name or function.__name__,
            callback=call,
            params=[*_parameters(function), *last],
            help=function.__doc__,
            short_help=short,
        )

    return bound


def _parameters(function: Callable[..., Any]) -> Iterator[click.Parameter]:
    for name, one in inspect.signature(function).parameters.items():
        if isinstance(one.default, Together):
            yield from _parameters(one.default.make)
        else:
            yield one.default.of(name, one.annotation)


def _called(function: Callable[..., Any], given: dict[str, Any]) -> Any:
    """What a function returns for the values of a command line."""
    passed = {}
    for name, one in inspect.signature(function).parameters.items():
        if isinstance(one.default, Together):
            passed[name] = _called(one.default.make, given)
        elif name in given:
            passed[name] = given[name]
    return function(**passed)
