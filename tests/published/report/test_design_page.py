"""``hfc report DESIGN`` as it is, with what the design does on other machines."""

import json
import re

from report_pages import FILE, HOSTILE, NAME
from run_folders import hfc

from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design


def test_it_has_the_parts_of_a_runs_page_without_the_search(tmp_path):
    record = json.loads(design_json(load_design(NAME)))
    record["provenance"]["scenario"] = {
        "name": "short",
        "description": HOSTILE,
        "plant": {"name": "c-axis"},
        "simulation": {"duration_s": 0.5},
        "reference": {"kind": "ramp"},
        "controller": {"kind": "pd+hierarchical-fuzzy"},
    }
    (tmp_path / FILE).write_text(json.dumps(record))
    done = hfc("report", tmp_path / FILE, "--out", tmp_path / "mine.html")
    assert (done.exit_code, done.stdout) == (0, f"{tmp_path / 'mine.html'}\n"), done.output
    text = (tmp_path / "mine.html").read_text()
    assert HOSTILE not in text
    assert re.findall("<h2>(.*?)</h2>", text) == [
        "Can I use it?",
        "What it does",
        "How good it is",
        "On other machines",
        "Changes that would give a yes, each on its own",
        "The controller",
        "Its units",
        "The loop",
        "How to reproduce it",
    ]
