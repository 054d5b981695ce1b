"""Cells of a batch that score a given design, and the published figures beside them."""

import csv
import json
import re
import tomllib

import pytest
from batches import batch, files, written
from places import ROOT
from run_folders import hfc

from hfc_design.batch.plan import read_batch
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design


def scores(out):
    """Score by label."""
    plan = json.loads((out / "batch.json").read_text())["cells"]
    return {
        settings["label"]: json.loads((out / name / "design.json").read_text())["score"]
        for name, settings in plan.items()
    }


def test_published_figures_by_hand(scored):
    with (scored / "published.csv").open(newline="") as file:
        weak, ratio, inside, missing, median = csv.DictReader(file)
    found = scores(scored)
    largest = {label: found[label]["max_error_rad"] for label in found}
    assert (ratio["figure"], weak["remark"]) == ("1", "b")
    assert float(weak["simulated"]) == largest["weak"]
    assert float(weak["ratio"]) == pytest.approx(largest["weak"] / 2e-3)
    better = found["strong"]["fitness"] / found["weak"]["fitness"]
    assert float(ratio["simulated"]) == pytest.approx(better)
    assert float(ratio["ratio"]) == pytest.approx(better / 4.0)
    assert float(inside["simulated"]) == largest["weak"] / found["weak"]["rms_error_rad"]
    assert (inside["published"], inside["ratio"]) == ("", "")
    middle = (largest["weak"] + largest["strong"]) / 2
    assert float(median["simulated"]) == pytest.approx(middle)
    assert (median["runs"], median["ratio"]) == ("2", "")
    assert (missing["simulated"], missing["runs"]) == ("", "0")


def test_a_cell_scores_what_hfc_score_says(scored):
    own = ("--set", "simulation.duration_s=0.2", "--json")
    for label, changes in (
        ("weak", ("--scenario", "c-axis-ramp", "--change", "controller.pd.kp=400")),
        ("strong", ("--scenario", "c-axis-ramp")),
        ("cutting", ("--scenario", "c-axis-ramp-cutting")),
    ):
        said = json.loads(hfc("score", "pd-only", *own, *changes).stdout)
        assert not said.pop("diverged")
        assert not said.pop("chaotic")
        assert (said.pop("substeps"), said.pop("divergence")) == (1, None)
        assert said.pop("design") == "pd-only"
        assert scores(scored)[label] == said


def test_broken_off_between_any_two_files(scored, tmp_path):
    """Whatever had been written, the same command ends with the same bytes."""
    of_pages = "report", "tables", "usable"
    undisturbed = {k: v for k, v in files(scored).items() if not any(x in k for x in of_pages)}
    path = written(tmp_path, (scored.parent / "mine.toml").read_text())
    kept = [set(), {design.GIVEN}, {design.GIVEN, design.CONFIG}]
    for cell, names in zip(read_batch(path).cells, kept, strict=True):
        (tmp_path / "out" / cell.name).mkdir(parents=True)
        for name in names:
            content = undisturbed[f"{cell.name}/{name}"]
            (tmp_path / "out" / cell.name / name).write_bytes(content)
    assert batch(path, "--out", tmp_path / "out").exit_code == 0
    assert files(tmp_path / "out") == undisturbed


def test_a_design_beside_the_file_and_its_own_scenario(tmp_path):
    assert hfc("export", "jee-koren-2004-flc", "--to", "json", "--out", tmp_path / "a.json")
    (cell,) = read_batch(written(tmp_path, '[set]\ndesign = "a.json"\n')).cells
    assert cell.scenario.name == "feed-drive-circle"
    first = cell.name
    text = (tmp_path / "a.json").read_text().replace("-32.0", "-31.0")
    (tmp_path / "a.json").write_text(text)
    assert read_batch(tmp_path / "mine.toml").cells[0].name != first  # another design, another run


def test_the_batch_files_of_the_documentation_can_be_planned(tmp_path):
    texts = []
    for page in ("docs/researcher.md", "docs/batch.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        texts += re.findall(r"^```toml\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    plans = [text for text in texts if "[grid]" in text or "published" in text]
    assert len(plans) == 3
    for text in plans:
        assert len(read_batch(written(tmp_path, text)).cells) >= 2
    (window,) = [text for text in texts if text.startswith("[[windows]]")]
    own = load_scenario("feed-drive-circle", {"windows": tomllib.loads(window)["windows"]})
    assert own.windows[0].name == "cycle_2"
