"""Names on a command line: their lists in the help and their completion in a shell."""

from collections.abc import Iterable, Mapping
from importlib import metadata
from textwrap import shorten
from typing import Any

import click
from click.shell_completion import CompletionItem

#: Kinds of things that may be a user's own -> their group of entry points of installed packages.
ENTRY_POINTS = {
    "plant": "hfc_design.plants",
    "controller": "hfc_design.controllers",
    "strategy": "hfc_design.strategies",
    "objective": "hfc_design.fitness",
}


#: Kinds of things that may be files as well.
FILES = "scenario", "design"


class Named(click.types.StringParamType):
    """Type of a parameter that is the name of a thing, or another value that the option accepts.

    A shell completes it to the names in the reference of hfc-design, and those of installed
    packages. Nothing here starts JAX.
    """

    name = "name"

    def __init__(self, kind: str = ""):
        """``kind`` is a kind of entries of the reference; "": the kind in the previous argument."""
        self.kind = kind

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the names that begin with the typed text, and files."""
        kind = self.kind or str(ctx.params.get("kind"))
        items = completions(meanings(kind), incomplete)
        # The file comes first: Bash drops all items before it, and if none follow, offers files.
        return [CompletionItem(incomplete, type="file"), *items] if kind in FILES else items


def meanings(kind: str) -> dict[str, str]:
    """Return name -> meaning, of all things of a kind."""
    from hfc_design.reference.entries import things

    known = {one.name: one.meaning for one in things(kind)}
    if kind in ENTRY_POINTS:
        installed = metadata.entry_points(group=ENTRY_POINTS[kind]).names
        known |= dict.fromkeys(sorted(installed), "of an installed package")
    return known


def completions(names: Mapping[str, str], incomplete: str) -> list[CompletionItem]:
    """Return the names that begin with the typed text, each with its meaning."""
    return [
        CompletionItem(name, help=shorten(meaning, 72, placeholder=" ..."))
        for name, meaning in names.items()
        if name.startswith(incomplete)
    ]


SCENARIO, DESIGN, OF_KIND = Named("scenario"), Named("design"), Named()
PLANT, FITNESS, CONTROLLER = Named("plant"), Named("objective"), Named("controller")
STRATEGY, FORMAT = Named("strategy"), Named("format")


class OrElse(click.Choice):  # type: ignore[type-arg]
    """Type of a parameter that is one of some names, or a synonym, such as plants for plant."""

    def __init__(self, choices: Iterable[str], others: Mapping[str, str]):
        """``choices`` are the names in the help, ``others`` the synonyms -> their names."""
        super().__init__([*choices])
        self.others = others

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name for a typed value."""
        return super().convert(self.others.get(value, value), param, ctx)


class NamedOption(click.Option):
    """An option in whose help NAMES is replaced by the available names."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Option and help, for a table."""
        record = super().get_help_record(ctx)
        if record is None or not isinstance(self.type, Named):
            return record
        return record[0], record[1].replace("NAMES", ", ".join(meanings(self.type.kind)))
