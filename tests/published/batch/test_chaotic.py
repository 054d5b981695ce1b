"""Runs whose designs are chaotic: told as ranges, compared by their lower ends."""

from run_folders import batch_folder, hfc, table

from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import with_score
from hfc_design.simulation.evaluating import evaluate

TWO = [
    ({"scenario": "a", "search.preset": "race"}, [430.0, 440.0]),
    ({"scenario": "a", "search.preset": "cma"}, [400.0, 401.0]),
]


def test_it_reads_what_a_run_writes(tmp_path):
    name, *_ = batch_folder(tmp_path, TWO)
    scenario, design = load_scenario("feed-drive-circle"), load_design("jee-koren-2004-aflc")
    found = evaluate(design, scenario)
    file = tmp_path / name / "design.json"
    file.write_text(design_json(with_score(design, found, scenario)))
    assert hfc("report", tmp_path).exit_code == 0
    row = next(row for row in table(tmp_path / "runs.csv") if row["run"] == name)
    many = found.repeats["fitness"]
    assert [float(row[key]) for key in ("fitness", "fitness_highest")] == [
        many.lowest,
        many.highest,
    ]
    assert (
        f"{many.lowest:.4g} to {many.highest:.4g} (chaotic)"
        in (tmp_path / "report.html").read_text()
    )
