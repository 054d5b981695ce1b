"""The page of the command line, from its commands and from what the other pages show of them."""

import inspect
import re
from pathlib import Path

import click

from hfc_design.cli import main

HEAD = """# Command line

What `hfc COMMAND --help` prints, from the commands themselves, with lines from the other pages.
`hfc --help` lists the commands, `hfc --version` says which version it is.
"""
#: Examples of a command that are shown at most.
SHOWN = 4


def examples(pages: list[Path]) -> dict[str, list[str]]:
    """Lines of the shell blocks of pages, by the command that they give."""
    found: dict[str, list[str]] = {name: [] for name in main.commands}
    for page in pages:
        for block in re.findall(r"^```sh\n(.*?)^```", page.read_text("utf-8"), re.M | re.S):
            for line in re.findall(r"^hfc .*(?:\\\n.*)*", block, re.M):
                if "\n" not in line:
                    found.setdefault(line.split()[1], []).append(re.sub("  +#", "  #", line))
    return found


def cell(text: str) -> str:
    """Text that Markdown takes as it is in a cell of a table."""
    return re.sub(r"([\\`*_\[\]<>|{}])", r"\\\1", text)


def section(name: str, command: click.Command, lines: list[str]) -> str:
    """Usage, text, examples and options of one command."""
    whole = click.Context(main, info_name="hfc", **main.context_settings)
    context = click.Context(command, info_name=name, parent=whole)  # else click forgets -h
    usage = " ".join([f"hfc {name}", *command.collect_usage_pieces(context)])
    rows = [
        f"| `{record[0]}` | {cell(record[1])} |"
        for one in command.get_params(context)
        if (record := one.get_help_record(context)) and record[1]
    ]
    text = cell(inspect.cleandoc(command.help or ""))
    shown = "".join(f"{line}\n" for line in lines[:SHOWN])
    return (
        f"\n## hfc {name}\n\n```text\n{usage}\n```\n\n{text}\n\n"
        + (f"```sh\n{shown}```\n\n" if shown else "")
        + "| option | what it does |\n|---|---|\n"
        + "\n".join(rows)
        + "\n"
    )


def page(pages: list[Path]) -> str:
    """The whole page; ``pages`` are searched for examples."""
    shown = examples(pages)
    return HEAD + "".join(
        section(name, command, shown[name]) for name, command in main.commands.items()
    )
