"""The command line as a user meets it."""

import csv
import re
import signal
from contextlib import suppress

import pytest
from places import ROOT
from run_folders import hfc
from wording import refused_command

from hfc_design.cli import main
from hfc_design.core.records import LONGEST
from hfc_design.files.design import builtin_designs, read_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import builtin_names


def test_help_lists_the_commands_as_their_page_introduces_them():
    page = (ROOT / "docs" / "commands.md").read_text()
    introduced = dict.fromkeys(re.findall(r"^hfc (\w+)", page, re.MULTILINE))
    listed = hfc("--help").stdout.split("Commands:")[1]
    assert re.findall(r"^  (\w+) ", listed, re.MULTILINE) == list(introduced)


def test_an_interrupt_that_a_library_tells_as_a_fault_of_its_own_is_one(monkeypatch):
    """As JAX does while it is imported."""

    def broken(*_, **__):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        raise ImportError("initialization failed")

    monkeypatch.setattr("hfc_design.files.named_scenario.load_scenario", broken)
    stopped = hfc("design")
    assert (stopped.exit_code, stopped.output.strip()) == (1, "Aborted!")


def test_a_value_of_an_option_is_quoted_no_longer_than_a_line():
    refused = refused_command("design", "c-axis-ramp", "--population", "a" * 5000)
    assert len(refused) <= LONGEST + 10


def test_export_json_reads_back_bit_for_bit(tmp_path):
    path = tmp_path / "out.json"
    assert hfc("export", "lin-lee-1999-table-1", "--to", "json", "--out", path).exit_code == 0
    assert read_design(path) == load_design("lin-lee-1999-table-1")


def test_export_csv_tables(tmp_path):
    path = tmp_path / "tables"
    assert hfc("export", "lin-lee-1999-table-2", "--to", "csv", "--out", path).exit_code == 0
    with (path / "manifest.csv").open(newline="") as file:
        manifest = list(csv.DictReader(file))
    assert [row["unit"] for row in manifest] == ["unit-3", "unit-1", "unit-2", "unit-0"]
    with (path / manifest[0]["file"]).open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == [
        "row previous_spindle_velocity \\ column error",
        *(f"f{k}" for k in range(1, 8)),
    ]
    assert float(rows[2][2]) == 1.7120  # Table II(a): row f2, column f2
    refused = refused_command("export", "lin-lee-1999-table-2", "--to", "csv", "--out", path)
    assert refused.where == f"--out {path}"


@pytest.mark.parametrize(
    ("what", "names"),
    [
        ("scenarios", builtin_names()),
        ("designs", builtin_designs()),
        ("plants", ["c-axis"]),
        ("controllers", ["pd", "pd+hierarchical-fuzzy"]),
        ("formats", ["json", "csv"]),
    ],
)
def test_lists(what, names):
    done = hfc("list", what)
    assert done.exit_code == 0
    for name in names:
        assert name in done.stdout


@pytest.mark.parametrize("command", main.commands)
def test_help_says_defaults_alike(command):
    """Brackets match, and none holds a number that does not say what it is."""
    for option in main.commands[command].params:
        told = getattr(option, "help", None) or ""
        assert re.fullmatch(r"([^\[\]]|\[[^\[\]]*\])*", told), told
        assert not re.search(r"\[[\d.]+\]", told), told
        assert "[default" not in told.partition(" [default: ")[0], told
