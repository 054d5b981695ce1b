"""Command lines that cannot be: one line with what is allowed, exit code 2."""

import click
import pytest
from click.testing import CliRunner
from plain_words import plain_lines

from hfc_design.cli import main, summary

DIGITS = "has to be a whole number"


def refused(*arguments):
    """What a command line is refused with, without ``hfc: ``."""
    done = CliRunner().invoke(main, [*arguments])
    assert (done.exit_code, done.stdout) == (2, "")
    lines = plain_lines(Exception(done.stderr.rstrip("\n")), "hfc: ")
    return "\n".join(line.removeprefix("hfc: ") for line in lines)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["design", "--polish", "-3"], f"--polish -3: {DIGITS} of 0 or more"),
        (["design", "--seed", "-1"], f"--seed -1: {DIGITS} of 0 or more"),
        (["design", "--population", "many"], f"--population many: {DIGITS}"),
        (
            ["design", "--precision", "f3"],
            "--precision f3: is none of them; there is float32, float64",
        ),
        (["export", "a", "--to", "c", "--lookup", "1"], f"--lookup 1: {DIGITS} from 2 to 32767"),
        (
            ["identify", "a", "--sample-time", "0"],
            "--sample-time 0: has to be a number more than 0",
        ),
        (
            ["list", "plnats"],
            "WHAT plnats: is none of them; did you mean plants? there is scenarios",
        ),
        (["list"], "list: WHAT is missing; main list -h tells what it takes"),
        (["export", "pd-only"], "export: --to is missing; main export -h tells what it takes"),
        (["design", "--seed"], "design: option '--seed' requires an argument"),
        (["design", "--polsh", "3"], "design: no such option '--polsh'; did you mean '--polish'?"),
        (["design", "a", "b"], "design: got unexpected extra argument (b)"),
        (["--bogus"], "no such option '--bogus'"),
        (["desing"], "desing: no such command; did you mean design? there is list, "),
        (
            ["export", "pd-only", "--to", "cc"],
            "--to cc: no such format; did you mean c? there is c",
        ),
        (["compare", "a", "--tolerance", "b"], "--tolerance: 'b': has to be as in backlash=0.5"),
    ],
)
def test_a_mistake_is_a_line_with_what_is_allowed(arguments, line):
    assert refused(*arguments).startswith(line)


def single(command):
    """The options of a command that take one value."""
    options = [one for one in command.params if isinstance(one, click.Option)]
    return [one.opts[0] for one in options if not (one.multiple or one.is_flag)]


@pytest.mark.parametrize(
    ("command", "option"),
    [(name, option) for name, command in main.commands.items() for option in single(command)],
)
def test_an_option_of_one_value_cannot_be_given_twice(command, option):
    line = refused(command, option, "1", option, "2")
    assert line == f"{command}: {option} is given 2 times; once is allowed"


@pytest.mark.parametrize(
    ("command", "option", "values"),
    [
        (["score", "pd-only"], "--set", ["limits.command=6", "limits.command =60"]),
        (["export", "pd-only"], "--change", ["plant.parameters.a=1", "plant.parameters.a=1"]),
        (["compare", "a"], "--tolerance", ["mass=0.1", "mass=0.2"]),
    ],
)
def test_a_key_of_an_option_cannot_be_given_twice(command, option, values):
    told = [text for value in values for text in (option, value)]
    key = values[0].partition("=")[0]
    assert refused(*command, *told) == f"{option} {key}: is given 2 times; once is allowed"


def test_options_of_several_values_and_flags_can():
    done = CliRunner().invoke(main, ["list", "formats", "--use", "a:B", "--use", "c:D"])
    assert "--use a:B" in done.stderr
    assert CliRunner().invoke(main, ["design", "--quiet", "--quiet", "-h"]).exit_code == 0


def test_every_fault_of_a_file_is_a_line_of_its_own(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("sed = 1\n[simulation]\nduration = 3\n[run]\npolish = -1\n")
    done = CliRunner().invoke(main, ["design", str(file), "--out", str(tmp_path / "run")])
    lines = done.stderr.splitlines()
    assert [line.startswith(f"hfc: {file}: ") for line in lines] == [True] * 3
    assert not (tmp_path / "run").exists()


def test_a_run_folder_where_a_scenario_is_wanted_tells_how_it_goes_on(tmp_path):
    (tmp_path / "config.toml").write_text("name = 'a'\n")
    line = refused("design", str(tmp_path))
    assert f"continue with: hfc design --resume --out {tmp_path}" in line
    assert "is a folder" in refused("design", str(tmp_path.parent))


@pytest.mark.parametrize("command", main.commands)
def test_summaries_are_whole(command):
    told = summary(main.commands[command])
    assert told.endswith(".")
    assert "..." not in told
    page = CliRunner().invoke(main, ["-h"]).stdout
    assert told in page  # in one line


def test_names_are_told_in_the_help():
    told = " ".join(CliRunner().invoke(main, ["design", "-h"]).stdout.split())
    assert "Search strategy: cma, l-shade, lin-lee-1999, nsga-ii, race [default:" in told
    assert "NAMES" not in told
