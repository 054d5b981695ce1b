"""``hfc compare`` as a user meets it."""

import json
import shutil

from run_folders import hfc

from hfc_design.files.design import BUILTIN

SHORT = ["--set", "simulation.duration_s=0.1", "--machines", "4"]


def test_run_folders_and_files_of_one_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        folder = tmp_path / "runs" / name
        folder.mkdir(parents=True)
        shutil.copy(BUILTIN / "pd-only.json", folder / "design.json")
    found = hfc("compare", "runs/one", "runs/two", *SHORT, "--json")
    assert found.exit_code == 0, found.output
    numbers = json.loads(found.stdout)
    assert numbers["designs"] == ["one", "two"]
    assert all(one["p"] == 1.0 and one["ratio"] == 1.0 for one in numbers["differences"])
