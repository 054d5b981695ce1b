"""A command is made of a function: what stands in its signature is what the command line takes."""

from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, Texts, Together, argument, command, option


def scaled(factor: float = option("Factor.", default=2.0), offset: int | None = option("Offset.")):
    return lambda x: factor * x + (offset or 0)


SCALED = Together(scaled)


@command("Scale NUMBER.")
def scale(
    number: float = argument(),
    law=SCALED,
    names: Texts = option("Names.", "--name"),
    least: int = option("Least.", low=1, default=1),
    out_file: Path | None = option("File."),
    loud: bool = option("Loud."),
    _as_json: bool = common.AS_JSON,
):
    """Scale NUMBER by a law."""
    found = {"value": law(number), "names": names, "least": least, "loud": loud}
    return Answer(found, lambda: click.echo(f"value {found['value']:g}"), [out_file or Path("-")])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("3", "value 6\n-\n"),
        ("3 --factor 0.5 --offset 1 --out-file a/b", "value 2.5\na/b\n"),
        (
            "3 --name a --name b --loud --json",
            '{"value": 6.0, "names": ["a", "b"], "least": 1, "loud": true}\n',
        ),
    ],
)
def test_values_of_a_command_line_reach_the_function(words, said):
    assert CliRunner().invoke(scale, words.split()).output == said


def test_help_is_that_of_the_signature_in_its_order():
    page = CliRunner().invoke(scale, ["--help"]).output
    assert "Scale NUMBER by a law." in page
    options = [line.split()[0] for line in page.partition("Options:")[2].splitlines() if line]
    assert options == [
        *("--factor", "--offset", "--name", "--least", "--out-file", "--loud", "--json", "--help")
    ]


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("3 --least 0", "--least 0: must be a whole number of at least 1"),
        ("3 --factor 1_0", "--factor 1_0: must be a number"),
        ("3 --factor 1 --factor 2", "--factor must be given once (got it 2 times)"),
    ],
)
def test_a_mistake_is_a_line(words, line):
    done = CliRunner().invoke(scale, words.split())
    assert (done.exit_code, done.stderr) == (2, f"hfc: {line}\n")
