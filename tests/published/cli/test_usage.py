"""Command lines that cannot be: one line with what is allowed, exit code 2."""

import subprocess
import sys

from click.testing import CliRunner
from plain_words import plain_lines

from hfc_design.cli import main


def refused(*arguments):
    """What a command line is refused with, without ``hfc: ``."""
    done = CliRunner().invoke(main, [*arguments])
    assert (done.exit_code, done.stdout) == (2, "")
    lines = plain_lines(Exception(done.stderr.rstrip("\n")), "hfc: ")
    return "\n".join(line.removeprefix("hfc: ") for line in lines)


def test_a_rate_of_learning_is_bounded():
    line = refused("train", "huang-soc", "--network", "rate=1e12", "--passes", "1")
    assert line == "--network: rate = 1000000000000.0: has to be 1000000 or less"


def test_a_page_of_an_experiment_tells_mistakes_in_a_line_too():
    for arguments in (["--identified", "missing.toml"], ["--machines", "x"]):
        call = [sys.executable, "-m", "experiments.emps.page", *arguments]
        done = subprocess.run(call, capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert done.stderr.startswith("hfc: ")
        assert done.stderr.count("\n") == 1
