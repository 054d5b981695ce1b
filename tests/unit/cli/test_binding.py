"""A command is made of a function; a shell completes its names."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.shell_completion import BashComplete, FishComplete, ZshComplete
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.cli.binding import Answer, Texts, Together, argument, command, option
from hfc_design.core.tables import text
from hfc_design.files.design import builtin_designs
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.files.named_scenario import builtin_names
from hfc_design.formats import FORMATS
from hfc_design.objectives.judge import OBJECTIVES
from hfc_design.search.loop import STRATEGIES


def scaled(factor: float = option("Factor.", default=2.0), offset: int | None = option("Offset.")):
    return lambda x: factor * x + (offset or 0)


SCALED = Together(scaled)


@command("Scale NUMBER.")
def scale(
    number: float = argument(),
    law=SCALED,
    names: Texts = option("Names.", "--name"),
    least: int = option("Least.", kind=click.IntRange(1), default=1),
    out_file: Path | None = option("File."),
    loud: bool = option("Loud."),
) -> Answer:
    """Scale NUMBER by a law."""
    found = {"value": law(number), "names": names, "least": least, "loud": loud}
    return Answer(found, lambda: [text(f"value {found['value']:g}")], [out_file or Path("-")])


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


SHELLS = BashComplete, ZshComplete, FishComplete


def completed(*words, shell=BashComplete):
    """The names that a shell offers for the last word."""
    *before, last = words
    own = shell(main, {}, "hfc", "_HFC_COMPLETE")
    return [one.value for one in own.get_completions(before, last) if one.type == "plain"]


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize(
    ("words", "names"),
    [
        (["design"], builtin_names()),
        (["score"], builtin_designs()),
        (["design", "--preset"], sorted(STRATEGIES.built_in)),
        (["design", "--plant"], sorted(ALL_PLANTS.built_in)),
        (["design", "--fitness"], sorted(OBJECTIVES.built_in)),
        (["plot"], builtin_designs()),
        (["show", "format"], sorted(FORMATS)),
    ],
)
def test_every_name_is_offered(shell, words, names):
    assert sorted(completed(*words, "", shell=shell)) == sorted(names)


@pytest.mark.parametrize("shell", SHELLS)
def test_what_begins_like_it_is_offered(shell):
    assert completed("des", shell=shell) == ["design"]
    assert completed("design", "mine", shell=shell) == []  # a shell looks for files then
    assert completed("score", "lin-lee", shell=shell) == [
        "lin-lee-1999-table-1",
        "lin-lee-1999-table-2",
    ]
    assert completed("design", "--pre", shell=shell) == ["--preset", "--precision"]
    assert completed("export", "pd-only", "--to", "fm", shell=shell) == [
        *("fml", "fmu", "fmu-loop", "fmu-plant")
    ]


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no Bash here")
def test_bash_takes_what_it_is_offered(tmp_path):
    """The script of the page, in a shell whose own half is played by the test."""
    (tmp_path / "hfc").write_text(f'#!/bin/sh\nexec {sys.executable} -m hfc_design "$@"\n')
    (tmp_path / "hfc").chmod(0o755)
    script = (
        "compopt() { :; }; complete() { :; }\n"
        'eval "$(_HFC_COMPLETE=bash_source hfc)"\n'
        "COMP_WORDS=(hfc export pd-only --to fm); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n"
        "_hfc_completion hfc\n"
        'printf "%s\\n" "${COMPREPLY[@]}"\n'
    )
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "--norc", "-c", script],
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    assert done.stdout.split() == ["fml", "fmu", "fmu-loop", "fmu-plant"]
