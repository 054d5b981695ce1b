import re

from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.verdict import baselines


def test_report_tells_fitness_rivals_and_structures(report):
    (scenario, result, folder, rivals), path = report
    text = path.read_text()
    assert f"{result.evaluation.fitness:.1f} on {scenario.name}" in text
    for evaluation in (result.evaluation, *rivals.values()):
        assert f"{evaluation.fitness:.4f}" in text
    assert "73 individuals diverged" in text
    assert text.count('</th><td class="value">110.0</td>') == 1
    assert len(re.findall(r'<tr><th scope="row">\(', text)) == 10
    assert sorted(file.name for file in (folder / "tables").iterdir()) == sorted(
        ["manifest.csv", *(f"unit-{unit.id}.csv" for unit in result.design.controller.units)]
    )


def test_the_loop_of_one_machine_is_a_rival_on_that_machine_only():
    stage = {"name": "x", "plant": {"name": "positioning-stage"}}
    stage |= {"reference": {"kind": "step", "height": 0.01}, "controller": {"kind": "pid"}}
    assert [*baselines(load_scenario(stage))] == ["emps-cascade"]
    assert not baselines(load_scenario(stage, {"plant.parameters.mass": 40.0}))
    other = load_scenario("c-axis-ramp", {"plant.parameters.stiffness": 150.0})
    assert len(baselines(other)) == 3
