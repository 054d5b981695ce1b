"""Cells of a batch that score a given design, and the published figures beside them."""

import json

import pytest
from batches import batch, written
from click.testing import CliRunner

from hfc_design.cli import main

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


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    path = tmp_path_factory.mktemp("scored")
    found = batch(written(path, PUBLISHED + SHORT + CELLS), "--out", path / "out")
    assert found.exit_code == 0, found.output
    return path / "out"


def test_the_page_begins_with_them(out):
    page = (out / "report.html").read_text()
    assert page.index("Published and simulated") < page.index("Groups")
    assert "nothing is random" in page
    assert "medians\nand quartiles are rough" not in page
    assert hfc("report", out, "--each").exit_code == 0
    for name in json.loads((out / "batch.json").read_text())["cells"]:
        own = (out / name / "report.html").read_text()
        assert "How it was found" not in own
        assert "hfc score given.json --scenario config.toml" in own
