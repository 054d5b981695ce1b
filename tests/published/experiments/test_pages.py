"""The pages of the experiments, their scenarios and their batch files, without a run."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from experiment_pages import EXPERIMENTS, page_of, table

from experiments.designed_tables import page as designed_tables
from experiments.huang_shy import page as huang
from experiments.jee_koren_1995 import page as jk95
from experiments.jee_koren_2004 import page as jk04
from experiments.lin_gai_2009 import page as lg09
from experiments.lin_lee_1999 import page as ll99
from hfc_design.batch.plan import read_batch
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario

SCENARIOS = [
    file
    for file in sorted(EXPERIMENTS.glob("*/*.toml"))
    if "\n[plant]" in file.read_text(encoding="utf-8")
]
BATCHES = [file for file in sorted(EXPERIMENTS.glob("*/*.toml")) if file not in SCENARIOS]


@pytest.mark.parametrize("module", [jk04, jk95, huang, lg09, ll99, designed_tables])
def test_a_page_without_its_batch_says_so(module, tmp_path):
    found = CliRunner().invoke(module.main, ["--runs", str(tmp_path)])
    assert found.exit_code == 2
    assert "run its batch first, with hfc batch" in found.output


@pytest.mark.parametrize("module", [jk04, jk95, huang, lg09, ll99])
def test_pages_show_pictures_that_are_there(module):
    place = Path(module.__file__).parent
    for picture in place.glob("*.svg"):
        assert f"]({picture.name})" in page_of(module)
        assert picture.stat().st_size < 60_000
    assert page_of(module).count("![") == len(list(place.glob("*.svg")))


@pytest.mark.parametrize("file", SCENARIOS, ids=lambda file: f"{file.parent.name}-{file.stem}")
def test_scenarios_can_be_used_by_hand(file):
    scenario = load_scenario(str(file))
    known = {"huang_shy": "huang-soc", "lin_gai_2009": "lin-gai-2009-pid", "emps": "emps-cascade"}
    known["identified_c_axis"] = "pd-only"
    beside = known.get(file.parent.name, "jee-koren-2004-flc")
    assert scenario.plant.name == load_design(beside).plant.name
    assert scenario.simulation.sample_time_s == load_design(beside).controller.sample_time_s


@pytest.mark.parametrize(
    "path",
    BATCHES,
    ids=lambda file: f"{file.parent.name}-{file.stem}",
)
def test_batch_files_are_plans(path):
    cells = read_batch(path).cells
    searched = {cell.scenario.run.seed for cell in cells if cell.design is None}
    assert searched in (set(), {0, 1, 2, 3, 4})
    page = (path.parent / "README.md").read_text(encoding="utf-8")
    command = f"hfc batch experiments/{path.parent.name}/{path.name}"
    assert command in page
    if path.stem == "batch":
        every = (EXPERIMENTS / "README.md").read_text(encoding="utf-8")
        assert f"| `{command}` | {'0 to 4' if searched else 'nothing random'} |" in every


def test_expected_numbers_stand_in_the_pages():
    """Which are compared with runs above, as far as a reduced budget can."""
    pages = {"Lin & Lee 1999": "lin_lee_1999", "Jee & Koren 2004": "jee_koren_2004",
             "Jee & Koren 1995": "jee_koren_1995", "Huang & Shy": "huang_shy",
             "Lin & Gai 2009": "lin_gai_2009", "this project": "designed_tables"}  # fmt: skip
    rows = [
        row
        for row in table((EXPERIMENTS / "README.md").read_text(encoding="utf-8"))
        if row[0] in pages
    ]
    assert len(rows) == 27
    for experiment, quantity, published, here in rows:
        page = (EXPERIMENTS / pages[experiment] / "README.md").read_text(encoding="utf-8")
        if "&" in experiment and experiment != "Lin & Lee 1999":
            same = [row for row in table(page) if row[1] == quantity.partition(", that of")[0]]
            assert (published, here) in [(row[2], row[3]) for row in same], quantity
        else:
            assert here in page, quantity
