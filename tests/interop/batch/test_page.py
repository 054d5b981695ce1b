"""The page of many runs, and the page of one that was run without."""

import json
import re
import shutil
import subprocess

import pytest
from run_folders import batch_folder, hfc

ACTIONS = """<script>
const buttons = [...document.querySelectorAll(".runs button")];
const button = buttons.find((one) => one.textContent == "fitness");
const rows = () => [...body.rows].filter((row) => !row.hidden);
const shown = () => rows().map((row) => row.cells[0].textContent);
const told = [];
button.click(); told.push(shown());
button.click(); told.push(shown());
search.value = "RACE finished"; search.oninput(); told.push(shown());
document.body.innerHTML = "<pre>" + JSON.stringify(told) + "</pre>";
</script>"""


def test_sorting_and_searching(tmp_path):
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no chromium on the PATH")
    values = [200.0, 30.0, 4.0]
    names = batch_folder(
        tmp_path / "out", [({"search.preset": p}, values[:n]) for p, n in (("race", 2), ("x", 3))]
    )
    (tmp_path / "out" / names[0] / "design.json").unlink()
    assert hfc("report", tmp_path / "out").exit_code == 0
    page = tmp_path / "acting.html"
    page.write_text((tmp_path / "out" / "report.html").read_text() + ACTIONS)
    options = f"--headless --no-sandbox --disable-gpu --user-data-dir={tmp_path}/profile --dump-dom"
    done = subprocess.run(
        [chromium, *options.split(), page.as_uri()],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    told = json.loads(re.search("<pre>(.*)</pre>", done.stdout)[1])
    # fitness: none (not finished), 30, 200, 30, 4
    a, b, c, d, e = (f"preset={p}, seed={k}" for p, n in (("race", 2), ("x", 3)) for k in range(n))
    assert told == [[e, b, d, c, a], [c, b, d, e, a], [b]]
