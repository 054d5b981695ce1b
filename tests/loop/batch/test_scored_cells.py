"""Cells of a batch that score a given design, and the published figures beside them."""

import csv
import json
import re
import tomllib

import pytest
from batches import batch, files, written
from click.testing import CliRunner
from places import ROOT

from hfc_design.batch.plan import read_batch
from hfc_design.cli import main
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design

SHORT = "[set]\nsimulation.duration_s = 0.2\n"
CELLS = """
[[cells]]
label = "weak"
scenario = "c-axis-ramp"
design = "pd-only"
change.controller.pd.kp = 400.0
[[cells]]
label = "strong"
scenario = "c-axis-ramp"
design = "pd-only"
[[cells]]
label = "cutting"
scenario = "c-axis-ramp-cutting"
design = "pd-only"
"""
PUBLISHED = """
published = [
    { quantity = "w", value = 2e-3, metric = "max_error_rad", remark = "b", of = "weak" },
    { figure = "1", quantity = "a", value = 4.0, metric = "fitness", of = "strong", over = "weak" },
    { quantity = "one run", metric = "max_error_rad", of = "weak", over_metric = "rms_error_rad" },
    { quantity = "never", value = 1.0, metric = "settling_time_s", of = "weak" },
    { quantity = "median", value = 0.0, metric = "max_error_rad", of.scenario = "c-axis-ramp" },
]
"""


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def scores(out):
    """Score by label."""
    plan = json.loads((out / "batch.json").read_text())["cells"]
    return {
        settings["label"]: json.loads((out / name / "design.json").read_text())["score"]
        for name, settings in plan.items()
    }


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    path = tmp_path_factory.mktemp("scored")
    found = batch(written(path, PUBLISHED + SHORT + CELLS), "--out", path / "out")
    assert found.exit_code == 0, found.output
    return path / "out"


def test_a_cell_scores_what_hfc_score_says(out):
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
        assert scores(out)[label] == said


def test_figures_of_two_batches_do_not_mix(out, tmp_path):
    for name, value in (("one", 400.0), ("two", 700.0)):
        text = f"""
        published = [{{ quantity = "{name}", metric = "max_error_rad", of = "same" }}]
        {SHORT}
        [[cells]]
        label = "same"
        design = "pd-only"
        change.controller.pd.kp = {value}
        """
        file = written(tmp_path, text, f"{name}.toml")
        assert batch(file, "--out", tmp_path / "both" / name).exit_code == 0
    assert hfc("report", tmp_path / "both").exit_code == 0
    with (tmp_path / "both" / "published.csv").open(newline="") as file:
        one, two = (float(row["simulated"]) for row in csv.DictReader(file))
    own = [scores(tmp_path / "both" / name)["same"]["max_error_rad"] for name in ("one", "two")]
    assert [one, two] == own
    assert one != two


def test_broken_off_between_any_two_files(out, tmp_path):
    """Whatever had been written, the same command ends with the same bytes."""
    of_pages = "report", "tables", "usable"
    undisturbed = {k: v for k, v in files(out).items() if not any(x in k for x in of_pages)}
    path = written(tmp_path, PUBLISHED + SHORT + CELLS)
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


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("change.controller.pd.kp = 4.0", "change.controller.pd.kp: needs a design"),
        ('design = "nope"', "nope: no such design"),
        ('design = "pd-only"\nchange.controller.pd.kx = 4.0', "controller.pd.kx"),
        ('design = "pd-only"\nscenario = "feed-drive-circle"', "is for the plant c-axis"),
        (
            'design = "pd-only"\nsimulation.sample_time_s = 0.002\nsimulation.substeps = 2',
            "runs every 0.001 s",
        ),
        ("design = 3", "3: no such design"),
        ("label = 3", "label: has to be a text of 1 to 120 letters"),
        ('label = "a\\u001bb"', "label: has to be a text"),
        (f'label = "{121 * "a"}"', "label: has to be a text"),
    ],
)
def test_cells_that_cannot_be(text, told, tmp_path):
    path = written(tmp_path, f"[set]\n{text}\n")
    with pytest.raises(UserError, match="cell with") as found:
        read_batch(path)
    assert told in str(found.value)
    assert str(path) in str(found.value)


def test_the_batch_files_of_the_documentation_can_be_planned(tmp_path):
    root = ROOT
    texts = []
    for page in ("docs/researcher.md", "docs/batch.md"):
        text = (root / page).read_text(encoding="utf-8")
        texts += re.findall(r"^```toml\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    plans = [text for text in texts if "[grid]" in text or "published" in text]
    assert len(plans) == 3
    for text in plans:
        assert len(read_batch(written(tmp_path, text)).cells) >= 2
    (window,) = [text for text in texts if text.startswith("[[windows]]")]
    own = load_scenario("feed-drive-circle", {"windows": tomllib.loads(window)["windows"]})
    assert own.windows[0].name == "cycle_2"
