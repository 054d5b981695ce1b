"""Tables of the commands in narrow terminals: nothing is wider, and no number is cut."""

import re

import pytest
from click.testing import CliRunner

from hfc_design.cli import main


@pytest.mark.parametrize("command", main.commands)
def test_help_fits_into_80_columns(command):
    """Of an option with many choices the first column is as long as they are."""
    told = CliRunner().invoke(main, [command, "-h"], env={"COLUMNS": "80"}).stdout
    assert max(map(len, told.splitlines())) <= 80
    assert not re.search(r"\w\.\.\.$", told, re.MULTILINE)
