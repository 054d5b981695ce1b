"""The command line as a user meets it."""

import csv
import io
import json
import re
import signal
import subprocess
import sys
from contextlib import suppress

import numpy as np
import pytest
from click.testing import CliRunner
from places import ROOT

from hfc_design.cli import main, shown
from hfc_design.cli.insight import LISTED
from hfc_design.core.plugins import know
from hfc_design.core.records import LONGEST
from hfc_design.files.design import builtin_designs, read_design
from hfc_design.files.named_scenario import builtin_names
from hfc_design.files.pairing import load_design

SMALL = ["--population", "12", "--generations", "3", "--set", "simulation.duration_s=0.1"]


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_help_does_not_import_jax():
    code = (
        "import sys\nfrom hfc_design.cli import main\n"
        "try:\n    main(['--help'])\nfinally:\n"
        "    print([m for m in sys.modules if m.split('.')[0] in ('jax', 'matplotlib', 'numpy')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
    assert "design" in done.stdout


@pytest.mark.parametrize(
    "arguments", [["score", "pd-only", "--set", "simulation.duration_s=0.1"], ["list", "plants"]]
)
def test_what_draws_nothing_does_not_import_what_draws(arguments):
    code = (
        "import sys\nfrom hfc_design.cli import main\n"
        f"try:\n    main({arguments})\nfinally:\n"
        "    print([m for m in sys.modules if m.split('.')[0] == 'matplotlib'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_help_lists_the_commands_as_their_page_introduces_them():
    page = (ROOT / "docs" / "commands.md").read_text()
    introduced = dict.fromkeys(re.findall(r"^hfc (\w+)", page, re.MULTILINE))
    listed = hfc("--help").stdout.split("Commands:")[1]
    assert re.findall(r"^  (\w+) ", listed, re.MULTILINE) == list(introduced)


def test_score_of_the_published_design_is_the_published_one():
    done = hfc("score", "lin-lee-1999-table-1", "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["fitness"] == pytest.approx(380.5715, abs=5e-5)
    assert found["scenario"] == "c-axis-ramp"
    assert found["stick_events"] == 0


def test_score_as_a_table_names_units_and_scenario():
    done = hfc("score", "lin-lee-1999-table-2")
    assert done.exit_code == 0
    for part in ("c-axis-ramp-cutting", "22.0256", "rms_error_rad", "peak_voltage_V"):
        assert part in done.stdout


def test_score_on_another_scenario_and_with_a_change():
    plain = json.loads(hfc("score", "pd-only", "--json").stdout)
    heavy = json.loads(
        hfc("score", "pd-only", "--json", "--set", "plant.parameters.spindle_inertia=8").stdout
    )
    other = json.loads(hfc("score", "pd-only", "--json", "--scenario", "c-axis-step").stdout)
    assert plain["fitness"] == pytest.approx(80.0197, abs=5e-5)
    assert len({plain["fitness"], heavy["fitness"], other["fitness"]}) == 3


def test_diverged_design_is_a_result(tmp_path):
    design = load_design("pd-only")
    wild = design.controller.pd.model_copy(update={"kd": 1e7})
    design = design.model_copy(
        update={"controller": design.controller.model_copy(update={"pd": wild})}
    )
    path = tmp_path / "wild.json"
    path.write_text(design.model_dump_json())
    done = hfc("score", path, "--json")
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["diverged"] is True
    assert found["fitness"] is None
    assert found["merit"] is None
    assert found["rms_error_rad"] is None
    assert "diverged" in hfc("score", path).stdout


def test_trajectory_csv_has_the_agreed_header_and_a_row_a_sample():
    done = hfc("simulate", "lin-lee-1999-table-1", "--set", "simulation.duration_s=0.5")
    rows = list(csv.reader(io.StringIO(done.stdout)))
    assert ",".join(rows[0]) == (
        "time_s,reference_rad,spindle_angle_rad,error_rad,spindle_velocity_rad_s,"
        "deflection_rad,voltage_V,load_torque_Nm"
    )
    data = np.array(rows[1:], float)
    assert data.shape == (500, 8)
    assert np.allclose(data[:, 1] - data[:, 2], data[:, 3], atol=1e-15)
    assert np.allclose(data[:, 0], np.arange(500) * 0.001)


def test_simulate_writes_files(tmp_path):
    done = hfc(
        "simulate", "pd-only", "--set", "simulation.duration_s=0.5",
        "--csv", tmp_path / "a.csv", "--plot", tmp_path / "a.png",
    )  # fmt: skip
    assert done.exit_code == 0
    assert done.stdout.split() == [str(tmp_path / "a.csv"), str(tmp_path / "a.png")]
    assert (tmp_path / "a.csv").read_text().count("\n") == 501
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_design_makes_a_run_and_shows_it_beside_the_published_ones(tmp_path):
    done = hfc("design", "c-axis-ramp", *SMALL, "--out", tmp_path / "run")
    assert done.exit_code == 0, done.output
    for part in ("this design", "fitness", "PD only", str(tmp_path / "run"), "report.html"):
        assert part in done.stdout
    assert "generation 3/3" in done.stderr
    assert "individual-steps/s" in done.stderr
    assert {path.name for path in (tmp_path / "run").iterdir()} == {
        "config.toml", "checkpoint.npz", "history.csv", "design.json", "report.html", "tables",
        "usable.json",
    }  # fmt: skip
    again = hfc("design", "c-axis-ramp", *SMALL, "--out", tmp_path / "run")
    assert again.exit_code == 2
    assert "already holds a run" in again.stderr
    resumed = hfc("design", "--resume", "--out", tmp_path / "run", "--quiet")
    assert resumed.exit_code == 0
    assert resumed.stderr == "hfc: warning: the design is not usable as it is\n"  # no progress
    assert resumed.stdout.startswith("Can I use it? no: ")


def _interrupted(self, search):
    raise KeyboardInterrupt


def test_interrupted_design_says_how_to_go_on(tmp_path, monkeypatch):
    monkeypatch.setattr(shown.Watch, "generation", _interrupted)
    done = hfc("design", "c-axis-ramp", *SMALL, "--out", tmp_path / "run")
    assert done.exit_code == 1
    assert f"hfc design --resume --out {tmp_path / 'run'}" in done.stderr
    assert (tmp_path / "run" / "checkpoint.npz").exists()
    for command in ("score", "simulate", "export --to c"):
        refused = hfc(*command.split(), tmp_path / "run")
        assert refused.exit_code == 2
        assert "holds no finished run (no design.json)" in refused.stderr
        assert f"hfc design --resume --out {tmp_path / 'run'}" in refused.stderr


def test_an_interrupt_that_a_library_has_ignored_is_heard_after_the_generation(
    tmp_path, monkeypatch
):
    def ignored(self, search):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(shown.Watch, "generation", ignored)
    done = hfc("design", "c-axis-ramp", *SMALL, "--out", tmp_path / "run")
    assert done.exit_code == 1
    assert "interrupted" in done.stderr
    assert len((tmp_path / "run" / "history.csv").read_text().splitlines()) == 3
    monkeypatch.undo()
    assert hfc("design", "--resume", "--out", tmp_path / "run", "--quiet").exit_code == 0


def test_an_interrupt_that_a_library_tells_as_a_fault_of_its_own_is_one(monkeypatch):
    """As JAX does while it is imported."""

    def broken(*_, **__):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        raise ImportError("initialization failed")

    monkeypatch.setattr("hfc_design.files.named_scenario.load_scenario", broken)
    stopped = hfc("design")
    assert (stopped.exit_code, stopped.output.strip()) == (1, "Aborted!")


def test_an_interrupt_that_nobody_could_hear_is_not_told_as_a_fault():
    """As in what a garbage collector calls; other faults there are told."""
    code = """
from hfc_design.core.interrupt import listen
class Gone:
    def __init__(self, fault): self.fault = fault
    def __del__(self): raise self.fault
listen()
Gone(KeyboardInterrupt())
Gone(ValueError("told"))
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "KeyboardInterrupt" not in ended.stderr
    assert "ValueError: told" in ended.stderr


def test_a_value_of_an_option_is_quoted_no_longer_than_a_line():
    refused = hfc("design", "c-axis-ramp", "--population", "a" * 5000)
    assert refused.exit_code == 2
    assert len(refused.stderr.splitlines()[-1]) <= LONGEST + 10
    assert refused.stderr.rstrip().endswith(": has to be a whole number")


@pytest.mark.slow
def test_how_to_go_on_and_how_to_repeat_name_own_parts(own, monkeypatch, no_baselines):
    know([])  # nothing of other tests
    with monkeypatch.context() as patched:
        patched.setattr(shown.Watch, "generation", _interrupted)
        stopped = hfc("design", "sledge.toml", "--plant", "mine:SLEDGE", "--out", "run")
    wanted = "hfc design --resume --out run --use mine:SLEDGE"
    assert stopped.stderr.rstrip().endswith(wanted)
    assert hfc(*wanted.split()[1:], "--quiet").exit_code == 0
    page = (own / "run" / "report.html").read_text()
    assert "hfc design config.toml --use mine:SLEDGE --out another-folder" in page


@pytest.mark.slow
def test_design_without_out_finds_a_free_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for number in (1, 2):
        assert hfc("design", "c-axis-ramp", *SMALL, "--quiet").exit_code == 0
        assert (tmp_path / "runs" / f"c-axis-ramp-{number}" / "design.json").exists()


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
    refused = hfc("export", "lin-lee-1999-table-2", "--to", "csv", "--out", path)
    assert refused.exit_code == 2
    assert "exists already" in refused.stderr


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


def test_export_csv_of_a_fuzzy_controller(tmp_path):
    path = tmp_path / "tables"
    assert hfc("export", "jee-koren-2004-flc", "--to", "csv", "--out", path).exit_code == 0
    tables = {file.name: list(csv.reader(file.read_text().splitlines())) for file in path.iterdir()}
    rules = tables["rules.csv"]
    assert (
        rules[0][1:] == [row[0] for row in rules[1:]] == ["NL", "NM", "NS", "ZR", "PS", "PM", "PL"]
    )
    assert rules[6] == ["PM", "8.0", "8.0", "8.0", "16.0", "16.0", "32.0", "32.0"]  # JK04 table 1
    assert tables["error_terms.csv"][1] == ["NL", "", "-21.0", "-16.0"]  # JK04 table 3
    assert tables["error_change_terms.csv"][5] == ["PS", "0.5", "1.5", "2.5"]
    assert tables["manifest.csv"][1][-1] == "rules.csv"


def test_list_names_what_it_lists_without_breaking_words():
    found = hfc("list", "--help").stdout
    assert "Usage: main list [OPTIONS] WHAT" in found or "list [OPTIONS] WHAT" in found
    for word in LISTED:
        assert word in found
    assert "law or kind" in " ".join(found.split())


@pytest.mark.parametrize("command", main.commands)
def test_help_says_defaults_alike(command):
    """Brackets match, and none holds a number that does not say what it is."""
    for option in main.commands[command].params:
        told = getattr(option, "help", None) or ""
        assert re.fullmatch(r"([^\[\]]|\[[^\[\]]*\])*", told), told
        assert not re.search(r"\[[\d.]+\]", told), told
        assert "[default" not in told.partition(" [default: ")[0], told


def test_a_start_of_another_kind_says_which_kind_it_has():
    refused = hfc("design", "feed-drive-contour", "--set", "controller.start=jee-koren-2004-flc")
    assert refused.exit_code == 2
    assert "is of kind flc, which needs controller.kind = 'flc'" in refused.stderr
