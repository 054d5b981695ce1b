"""The command line as a user meets it."""

import subprocess
import sys

from run_folders import hfc

SMALL = ["--population", "12", "--generations", "3", "--set", "simulation.duration_s=0.1"]


def test_what_draws_nothing_does_not_import_what_draws():
    arguments = ["score", "pd-only", "--set", "simulation.duration_s=0.1"]
    code = (
        "import sys\nfrom hfc_design.cli import main\n"
        f"try:\n    main({arguments})\nfinally:\n"
        "    print([m for m in sys.modules if m.split('.')[0] == 'matplotlib'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_design_makes_a_run_and_shows_it_beside_the_published_ones(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")  # no head is wrapped
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
    assert "already has a run" in again.stderr
    resumed = hfc("design", "--resume", "--out", tmp_path / "run", "--quiet")
    assert resumed.exit_code == 0
    assert resumed.stderr == "hfc: warning: the design is not usable as it is\n"  # no progress
    assert resumed.stdout.startswith("Can I use it? no: ")


def test_design_without_out_finds_a_free_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for number in (1, 2):
        assert hfc("design", "c-axis-ramp", *SMALL, "--quiet").exit_code == 0
        assert (tmp_path / "runs" / f"c-axis-ramp-{number}" / "design.json").exists()
