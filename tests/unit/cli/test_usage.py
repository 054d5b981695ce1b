"""Command lines that cannot be: one line with what is allowed, exit code 2."""

from shlex import split

import click
import pytest
from plain_words import plain_lines
from run_folders import hfc
from wording import refused_command

from hfc_design.cli import main

#: Command line -> what its refusal begins with.
MISTAKES = {
    "design --polish -3": "--polish -3",
    "design --precision f3": "--precision f3",
    "export a --to c --lookup 1": "--lookup 1",
    "identify a --sample-time 1_0": "--sample-time 1_0",
    "score pd-only --samples 1_0": "--samples 1_0",
    "explain jee-koren-2004-flc --at error=1_0,error_change=0": "--at 'error=1_0'",
    "frequency pd-only --amplitude 0.1 --amplitude 1_0": "--amplitude 1_0",
    "explain jee-koren-2004-flc --at error=１,error_change=0": "--at 'error=１'",
    "score pd-only --memory １GB": "--memory or HFC_MEMORY １GB",
    "list plnats": "WHAT plnats",
    "explain": "explain",
    "export pd-only": "export",
    "design --polsh 3": "design",
    "--bogus": "no such option '--bogus'",
    "desing": "desing",
    "compare a --tolerance b": "--tolerance b",
    "stability --gain -1": "--gain -1.0",
    "stability --sample-time 0": "--sample-time 0.0",
    "stability --sample-time 9": "sample time / time constant",
    "stability --plot range.gif": "range.gif",
    "stability --plot none/range.png": "--plot none/range.png",
    "score pd-only --set limits.command=6 --set 'limits.command =60'": "--set limits.command",
    "export pd-only --change plant.a=1 --change plant.a=1": "--change plant.a",
    "init --controller cross-coupled": "--controller cross-coupled",
    "init --plant c-axsi": "'c-axsi'",
    "init --plant positioning-stage --controller pd": "--controller pd",
    "attainable c-axis-ramp": "scenario c-axis-ramp has no limits.command",
    "simulate pd-only --csv a.png --plot ./a.png": "--plot a.png",
    "simulate jee-koren-2004-aflc --learned nowhere/a.json": "--learned nowhere/a.json",
    "show plant c-axsi": "'c-axsi'",
    "show design pd-onyl": "pd-onyl",
    "show key simulation.duration": "'simulation.duration'",
    "show key spindle_inertia": "'spindle_inertia'",
    "show key sensors.encoder": "'sensors.encoder'",
}


@pytest.mark.parametrize("command", MISTAKES)
def test_a_mistake_is_a_line_with_what_is_allowed(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = refused_command(*split(command))
    assert line.where == MISTAKES[command]
    assert len(plain_lines(Exception(line.rstrip()), "hfc: ")) == 1
    assert [*tmp_path.iterdir()] == []


@pytest.mark.parametrize("command", ["list", "show"])
def test_without_an_argument_a_list_is_its_help(command):
    done = hfc(command)
    assert done.exit_code == 2
    assert done.stderr == hfc(command, "-h").stdout + "\n" * (not done.stderr.endswith("\n"))


def single(command):
    """The options of a command that take one value."""
    options = [one for one in command.params if isinstance(one, click.Option)]
    return [one.opts[0] for one in options if not (one.multiple or one.is_flag)]


@pytest.mark.parametrize(
    ("command", "option"),
    [(name, option) for name, command in main.commands.items() for option in single(command)],
)
def test_an_option_of_one_value_cannot_be_given_twice(command, option):
    told = hfc(command, option, "1", option, "2").stderr
    assert told == f"hfc: {command}: {option} must be given once (got it 2 times)\n"


def test_options_of_several_values_and_flags_can():
    line = refused_command("list", "formats", "--use", "a:B", "--use", "c:D")
    assert line.where == "--use a:B"
    assert hfc("design", "--quiet", "--quiet", "-h").exit_code == 0


def test_every_fault_of_a_file_is_a_line_of_its_own(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("sed = 1\n[simulation]\nduration = 3\n[run]\npolish = -1\n")
    lines = refused_command("design", file, "--out", tmp_path / "run").splitlines()
    assert [line.startswith(f"hfc: {file}: ") for line in lines] == [True] * 3
    assert not (tmp_path / "run").exists()
