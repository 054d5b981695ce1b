"""Parameters that take a name: what there is, in the help and for the completion of a shell.

The names are those of the reference that comes with the package, and of installed packages:
nothing here starts JAX.
"""

from collections.abc import Callable, Iterable, Mapping
from importlib import metadata
from textwrap import shorten
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

Decorated = TypeVar("Decorated", bound=Callable[..., Any] | click.Command)


class Named(click.types.StringParamType):
    """A name of one thing: built in, of an installed package, or what else its option takes."""

    name = "name"

    def __init__(self, kind: str, entry_points: str = "", files: bool = False):
        """``kind`` is that of the entries of the reference; with ``files`` a path will do too."""
        self.kind, self.entry_points, self.files = kind, entry_points, files

    def told(self) -> dict[str, str]:
        """Every name, with what it is."""
        from hfc_design.reference.entries import things

        found = {one.name: one.meaning for one in things(self.kind)}
        if self.entry_points:
            installed = metadata.entry_points(group=self.entry_points).names
            found |= dict.fromkeys(sorted(installed), "of an installed package")
        return found

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """The names that begin like this, and files."""
        items = [
            CompletionItem(name, help=shorten(meaning, 72, placeholder=" ..."))
            for name, meaning in self.told().items()
            if name.startswith(incomplete)
        ]
        # In front: Bash forgets what came before, and takes files where no name begins so.
        return [CompletionItem(incomplete, type="file"), *items] if self.files else items


SCENARIO = Named("scenario", files=True)
DESIGN = Named("design", files=True)
PLANT = Named("plant", "hfc_design.plants")
FITNESS = Named("objective", "hfc_design.fitness")
CONTROLLER = Named("controller", "hfc_design.controllers")
STRATEGY = Named("strategy", "hfc_design.strategies")
FORMAT = Named("format")
ALL = {one.kind: one for one in (SCENARIO, DESIGN, PLANT, FITNESS, CONTROLLER, STRATEGY)}


class NamedOfKind(click.types.StringParamType):
    """A name of the kind that the argument before it says."""

    name = "name"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """The names of that kind."""
        kind = str(ctx.params.get("kind"))
        return ALL.get(kind, Named(kind)).shell_complete(ctx, param, incomplete)


class OrElse(click.Choice):  # type: ignore[type-arg]
    """One of some names; each of ``others`` stands for one of them too, as plants for plant."""

    def __init__(self, choices: Iterable[str], others: Mapping[str, str]):
        """Of both what the help has and what else is understood."""
        super().__init__([*choices])
        self.others = others

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The name that is meant."""
        return super().convert(self.others.get(value, value), param, ctx)


class NamedOption(click.Option):
    """An option whose help has the names that there are in the place of NAMES."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Option and help, for a table."""
        found = super().get_help_record(ctx)
        if found is None or not isinstance(self.type, Named):
            return found
        return found[0], found[1].replace("NAMES", ", ".join(self.type.told()))


def named(*names: str, kind: Named, **others: Any) -> Callable[[Decorated], Decorated]:
    """An option that takes a name; NAMES in its help are those that there are."""
    return click.option(*names, cls=NamedOption, type=kind, metavar="NAME", **others)
