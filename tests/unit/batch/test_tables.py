"""The tables of many runs as CSV, as Parquet, in a paper and on their page."""

import sys
from collections import Counter
from html.parser import HTMLParser

import pytest
from run_folders import HOSTILE, PRESETS, batch_folder, hfc, table
from wording import refused_command


def test_parquet_holds_what_the_csv_holds(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    batch_folder(tmp_path, PRESETS)
    assert hfc("report", tmp_path, "--parquet").exit_code == 0
    stored = parquet.read_table(tmp_path / "runs.parquet").to_pydict()
    rows = table(tmp_path / "runs.csv")
    assert list(stored) == list(rows[0])
    for key, values in stored.items():
        assert [("" if v is None else str(v)) for v in values] == [row[key] for row in rows]
    assert stored["fitness"][0] == 10.0
    assert stored["run.seed"][:2] == [0, 1]


def test_parquet_without_pyarrow(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    batch_folder(tmp_path, PRESETS)
    refused_command("report", tmp_path, "--parquet")
    assert not (tmp_path / "runs.csv").exists()


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
