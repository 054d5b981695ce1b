"""Turns functions into commands: their parameters become arguments and options.

A parameter has its type as annotation, and its other properties on the command line as default::

    @command("Draw a picture.")
    def draw(name: str = argument(DESIGN), width: float | None = option("Width [mm].")) -> None:

A parameter whose name begins with ``_`` acts by its callback alone and is not passed on.
"""

import inspect
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_args

import click

from hfc_design.cli.names import Named, NamedOption
from hfc_design.cli.usage import Plain
from hfc_design.core.tables import Table

Texts = tuple[str, ...]
PATH = click.Path(path_type=Path)


class Parameter(NamedTuple):
    """Description of an argument or option, without its name and type."""

    make: type[click.Parameter]
    names: tuple[str, ...]  # of an option, as "--to"; (): made from the name of the parameter
    kind: Any  # click's type; None: from the annotation
    settings: dict[str, Any]  # click's keywords

    def of(self, name: str, annotation: Any) -> click.Parameter:
        """Return the click parameter for a function's parameter with this name and annotation."""
        settings = {"expose_value": not name.startswith("_"), **self.settings}
        types = [one for one in get_args(annotation) if one is not type(None)] or [annotation]
        plain = str if annotation == Texts else PATH if types[0] is Path else types[0]
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
    """Default of a parameter that ``make`` computes from its own parameters on the command line."""

    make: Callable[..., Any]


def argument(kind: Any = None, **settings: Any) -> Any:
    """Return the default of a parameter that is a positional argument; ``settings`` are click's."""
    return Parameter(click.Argument, (), kind, settings)


def option(text: str | None, *names: str, kind: Any = None, **settings: Any) -> Any:
    """Return the default of a parameter that is an option; ``text`` is its help."""
    return Parameter(NamedOption, names, kind, {"help": text, **settings})


class Answer(NamedTuple):
    """Result of a command."""

    numbers: Any  # what --json prints
    tables: Callable[[], Iterable[Table]]  # what the command prints otherwise
    files: Sequence[Path] = ()  # written files, whose paths are printed after the tables
    indent: int | None = None  # indentation of the JSON
    ascii: bool = True  # whether the JSON has ASCII characters only

    def print(self, as_json: bool) -> None:
        """Print the result on stdout, as JSON or as text."""
        if as_json:
            click.echo(json.dumps(self.numbers, indent=self.indent, ensure_ascii=self.ascii))
            return
        from hfc_design.core.console import show  # which imports rich

        show(*self.tables())
        for path in self.files:
            click.echo(path)


class Output(NamedOption):
    """An option for a path that is written, for which its command has --force."""


def noted(context: click.Context, option: click.Parameter, value: bool) -> bool:
    """Store a flag in ``meta`` of the context, as hfc.force; a callback of an option."""
    return context.meta.setdefault(f"hfc.{option.opts[0][2:]}", value)


AS_JSON = option("Print one JSON object.", "--json", is_flag=True, callback=noted)
#: Eager, because the callbacks of paths read it.
FORCE = option("Overwrite existing files.", is_flag=True, is_eager=True, callback=noted)


def command(
    short: str | None = None,
    name: str | None = None,
    last: Iterable[click.Parameter] = (),
    **settings: Any,
) -> Callable[[Callable[..., Answer | None]], click.Command]:
    """Return a decorator that makes a command of a function, whose docstring becomes the help.

    ``short`` is its line in a list of commands. The ``last`` parameters follow those of the
    function and are not passed to it. A command with an output has --force, one that returns an
    answer --json. ``settings`` are click's.
    """

    def bound(function: Callable[..., Answer | None]) -> click.Command:
        def call(**given: Any) -> None:
            if answer := _called(function, given):
                answer.print(click.get_current_context().meta["hfc.json"])

        parameters = [*_parameters(function)]
        if any(isinstance(one, Output) for one in parameters):
            parameters.append(FORCE.of("_force", bool))
        if function.__annotations__.get("return") is Answer:
            parameters.append(AS_JSON.of("_json", bool))
        return Plain(
            name or function.__name__,
            callback=call,
            params=[*parameters, *last],
            help=_text(function),
            short_help=short,
            **settings,
        )

    return bound


def _parameters(function: Callable[..., Any]) -> Iterator[click.Parameter]:
    for name, one in inspect.signature(function).parameters.items():
        if isinstance(one.default, Together):
            yield from _parameters(one.default.make)
        else:
            yield one.default.of(name, one.annotation)


def _text(function: Callable[..., Any]) -> str:
    """Return the docstring of a command, and the texts of functions from which it is made."""
    defaults = (one.default for one in inspect.signature(function).parameters.values())
    makers = [one.make.__doc__ or "" for one in defaults if isinstance(one, Together)]
    return "\n\n".join([inspect.cleandoc(function.__doc__ or ""), *makers]).strip()


def _called(function: Callable[..., Any], given: dict[str, Any]) -> Any:
    """Call a function with the values of a command line that are its parameters."""
    passed = {}
    for name, one in inspect.signature(function).parameters.items():
        if isinstance(one.default, Together):
            passed[name] = _called(one.default.make, given)
        elif name in given:
            passed[name] = given[name]
    return function(**passed)
