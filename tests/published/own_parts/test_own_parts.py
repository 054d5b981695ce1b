"""A run with parts of a user's own, in a process that has never heard of them."""

import subprocess
import sys

from places import OWN_PARTS
from run_folders import ran
from toy_run import OWN, SCENARIO


def test_it_is_reported_and_who_lacks_it_is_told_what_to_add(tmp_path, own_plugins, known_use):
    sys.path.insert(0, str(OWN_PARTS))
    (tmp_path / "toy.toml").write_text(SCENARIO)
    ran("design", tmp_path / "toy.toml", *OWN, "--out", tmp_path / "run", "--quiet")
    found = subprocess.run(
        [sys.executable, "-m", "hfc_design", "score", tmp_path / "run"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert found.returncode == 2
    assert "its provenance names --use toy_machine:MACHINE --use toy_kind:KIND" in found.stderr
    page = (tmp_path / "run" / "report.html").read_text()
    assert "x: A table of its own" in page
    assert "The learnt table." in page
