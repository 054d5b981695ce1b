"""The page of many runs, and the page of one that was run without."""

import json
import re
import shutil
import subprocess
from collections import Counter
from html.parser import HTMLParser

import phone
import pytest
from run_folders import HOSTILE, batch_folder, hfc, table

TINY = """
[set]
search.population = 16
search.generations = 3
simulation.duration_s = 0.1
[grid]
search.preset = ["race", "lin-lee-1999"]
run.seed = [0]
"""


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses = Counter(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags[tag] += 1
        self.addresses += [value for key, value in attributes if key in ("src", "href")]


def test_hostile_settings_are_only_text(tmp_path):
    folder = tmp_path / "<i>"
    names = batch_folder(folder, [({"description": HOSTILE + str(k)}, [k, 9.0]) for k in (2, 3)])
    (folder / names[0] / "report.html").touch()
    assert hfc("report", folder).exit_code == 0
    text = (folder / "report.html").read_text()
    page = Page(text)
    assert page.tags["script"] == 1
    assert page.tags["i"] == 0
    assert "alert(&#34;1&#34;)" in text
    assert page.tags["figure"] == 2
    assert [address for address in page.addresses if not address.startswith("data:image/svg")] == [
        f"{names[0]}/report.html"
    ]


def test_two_thousand_runs_stay_readable(large):
    text = (large / "report.html").read_text()
    page = Page(text)
    assert len(text) < 2_000_000
    assert page.tags["tr"] > 2000
    assert page.tags["figure"] == 4
    assert all(address.startswith("data:image/svg+xml") for address in page.addresses)
    assert len(table(large / "comparisons.csv")) == 2 * 190
    assert "280 more are in <code>comparisons.csv" in text
    assert text.index("<h2>Groups") < text.index("<h2>Every run")


@pytest.mark.slow
def test_the_page_of_a_run_is_that_of_hfc_design(tmp_path):
    """A cell of a batch has none; what is written later is what hfc design writes at once."""
    (tmp_path / "mine.toml").write_text(TINY)
    out = tmp_path / "out"
    assert hfc("batch", tmp_path / "mine.toml", "--out", out).exit_code == 0
    assert list(out.glob("*/report.html")) == []
    assert hfc("report", out, "--each").exit_code == 0
    pages = sorted(out.glob("*/report.html"))
    assert len(pages) == 2
    assert all(
        f'href="{p.parent.name}/report.html"' in (out / "report.html").read_text() for p in pages
    )
    own = pages[0].parent
    assert hfc("design", own / "config.toml", "--out", tmp_path / "again", "--quiet").exit_code == 0
    for file in ("report.html", "tables/manifest.csv", "design.json"):
        assert (own / file).read_bytes() == (tmp_path / "again" / file).read_bytes()
    first = pages[0].read_bytes()
    pages[0].write_text("old")
    assert hfc("report", own).exit_code == 0
    assert pages[0].read_bytes() == first
    assert "--each" in hfc("report", own, "--each").stderr
    (own / "checkpoint.npz").unlink()
    assert "is gone" in hfc("report", own).stderr
    pages[0].unlink()
    found = hfc("report", out, "--each")
    assert found.exit_code == 1
    assert "1 of the runs got no page of their own" in found.stderr


@pytest.mark.browser
def test_the_page_on_a_phone(large, tmp_path):
    assert phone.figures_that_fit(large / "report.html", tmp_path) == 4


ACTIONS = """<script>
const buttons = [...document.querySelectorAll("#all button")];
const button = buttons.find((one) => one.textContent == "fitness");
const rows = () => [...body.rows].filter((row) => !row.hidden);
const shown = () => rows().map((row) => row.cells[0].textContent);
const told = [];
button.click(); told.push(shown());
button.click(); told.push(shown());
search.value = "RACE finished"; search.oninput(); told.push(shown());
document.body.innerHTML = "<pre>" + JSON.stringify(told) + "</pre>";
</script>"""


@pytest.mark.browser
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
    a, b, c, d, e = names  # fitness: none (not finished), 30, 200, 30, 4
    assert told == [[e, b, d, c, a], [c, b, d, e, a], [b]]
