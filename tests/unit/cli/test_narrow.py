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


@pytest.mark.parametrize("width", ["60", "80", "120"])
def test_no_number_of_a_table_is_cut(width):
    told = CliRunner().invoke(main, ["list", "plants"], env={"COLUMNS": width}).stdout
    assert "…" not in told
    assert max(map(len, told.splitlines())) <= int(width)
    assert {"120000", "-0.04"} <= {*told.split()}
