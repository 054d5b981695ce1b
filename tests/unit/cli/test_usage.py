"""Command lines that cannot be: one line with what is allowed, exit code 2."""

from shlex import split

import click
import pytest
from plain_words import plain_lines
from run_folders import hfc
from wording import refused_command

from hfc_design.cli import main, summary

#: Command line -> what its refusal begins with.
MISTAKES = {
    "design --polish -3": "--polish -3",
    "design --seed -1": "--seed -1",
    "design --population many": "--population many",
    "design --precision f3": "--precision f3",
    "export a --to c --lookup 1": "--lookup 1",
    "identify a --sample-time 0": "--sample-time 0",
    "identify a --sample-time 1_0": "--sample-time 1_0",
    "design --seed １": "--seed １",
    "score pd-only --samples 1_0": "--samples 1_0",
    "explain jee-koren-2004-flc --at error=1_0,error_change=0": "--at 'error=1_0'",
    "explain jee-koren-2004-flc --at error=１,error_change=0": "--at 'error=１'",
    "score pd-only --memory １GB": "--memory or HFC_MEMORY １GB",
    "score pd-only --memory 8\u212aB": "--memory or HFC_MEMORY 8\u212aB",
    "score pd-only --set simulation.duration_s='\"1_0\"'": "c-axis-ramp",
    "list plnats": "WHAT plnats",
    "list": "list",
    "export pd-only": "export",
    "design --seed": "design",
    "design --polsh 3": "design",
    "design a b": "design",
    "--bogus": "no such option '--bogus'",
    "desing": "desing",
    "export pd-only --to cc": "--to cc",
    "compare a --tolerance b": "--tolerance",
    "stability --gain -1": "--gain -1.0",
    "stability --gain much": "--gain much",
    "stability --time-constant nan": "--time-constant nan",
    "stability --sample-time 0": "--sample-time 0.0",
    "stability --sample-time 9": "sample time / time constant",
    "stability --plot range.gif": "range.gif",
    "stability --plot none/range.png": "--plot none/range.png",
    "score pd-only --set limits.command=6 --set 'limits.command =60'": "--set limits.command",
    "export pd-only --change plant.a=1 --change plant.a=1": "--change plant.a",
    "compare a --tolerance mass=0.1 --tolerance mass=0.2": "--tolerance mass",
    "init --controller cross-coupled": "--controller cross-coupled",
    "init --plant c-axsi": "'c-axsi'",
    "init --plant positioning-stage --controller pd": "--controller pd",
    "attainable c-axis-ramp": "scenario c-axis-ramp has no limits.command",
    "attainable nowhere": "nowhere",
    "simulate pd-only --plot mine.bmp": "mine.bmp",
    "simulate pd-only --csv a.png --plot ./a.png": "--plot a.png",
    "simulate jee-koren-2004-aflc --learned nowhere/a.json": "--learned nowhere/a.json",
    "train pd-only --out nowhere/a.json": "--out nowhere/a.json",
    "show plant c-axsi": "'c-axsi'",
    "show scenario c-axis-rampp": "c-axis-rampp",
    "show design pd-onyl": "pd-onyl",
    "show key simulation.duration": "'simulation.duration'",
    "show key spindle_inertia": "'spindle_inertia'",
    "show key sensors.encoder": "'sensors.encoder'",
    "show key Search.Population": "'Search.Population'",
    "show controller PID": "'PID'",
}


@pytest.mark.parametrize("command", MISTAKES)
def test_a_mistake_is_a_line_with_what_is_allowed(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = refused_command(*split(command))
    assert line.where == MISTAKES[command]
    assert len(plain_lines(Exception(line.rstrip()), "hfc: ")) == 1
    assert [*tmp_path.iterdir()] == []


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


def test_a_run_folder_where_a_scenario_is_wanted_tells_how_it_goes_on(tmp_path):
    (tmp_path / "config.toml").write_text("name = 'a'\n")
    assert refused_command("design", tmp_path).where == str(tmp_path)
    (tmp_path / "other").mkdir()
    assert refused_command("design", tmp_path / "other").where == str(tmp_path / "other")


@pytest.mark.parametrize("command", main.commands)
def test_summaries_are_whole(command):
    told = summary(main.commands[command])
    assert told.endswith(".")
    assert "..." not in told
    page = hfc("-h").stdout
    assert told in page  # in one line
