"""Repeats a millionth apart: against designs whose gains are multiplied by hand."""

import pytest

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate, notes, score_rows
from hfc_design.simulation.repeats import FACTORS

CIRCLE = "feed-drive-circle"


def louder_hierarchy(design, factor):
    """Its PD and its output times a factor."""
    gains = design.controller.pd
    changes = {"pd.kp": factor * gains.kp, "pd.kd": factor * gains.kd}
    changes["output_scale"] = factor * design.controller.output_scale
    return load_design(design, [f"controller.{key}={float(x)!r}" for key, x in changes.items()])


def louder_aflc(design, factor):
    """Its table, the steps of it and their bounds times a factor; there is no integral."""
    own = design.controller
    table = [[factor * x for x in row] for row in own.rules.centroids]
    changes = {"rules.centroids": table, "adaptation.k_c": factor * own.adaptation.k_c}
    for key, bound in own.adaptation.stable_range.model_dump().items():
        changes[f"adaptation.stable_range.{key}"] = factor * bound
    return load_design(design, [f"controller.{key}={x!r}" for key, x in changes.items()])


def test_a_published_design_that_a_millionth_moves_is_told_as_a_range():
    """The AFLC of 2004 on a circle: one of two motions, by the last bits of its table."""
    scenario, design = load_scenario(CIRCLE), load_design("jee-koren-2004-aflc")
    found = evaluate(design, scenario)
    many = found.repeats["fitness"]
    some = [1, 20, 45, 63]
    alone = [evaluate(louder_aflc(design, float(FACTORS[k])), scenario).fitness for k in some]
    assert many.values[some] == pytest.approx(alone, rel=1e-6)
    assert [many.lowest, many.highest] == pytest.approx([min(alone), max(alone)], rel=1e-6)
    assert many.highest > 1.05 * many.lowest
    assert many.values[0] == found.fitness
    assert found.chaotic
    assert found.worth == many.lowest

    score = found.score(scenario.judge())
    ends = {"lowest": min(alone), "highest": max(alone), "count": 64}
    assert score["chaotic"] is True
    assert {key: score["repeats"]["fitness"][key] for key in ends} == pytest.approx(ends, rel=1e-6)
    (_, told), *_ = score_rows(scenario.judge(), [found]).values()
    assert told == f"{min(alone):.4g} to {max(alone):.4g} (chaotic)"
    (note,) = notes(scenario, {"it": found})
    repeats = "in 64 repeats with the command changed by up to one millionth"
    ends = f"fitness ranges from {min(alone):.4g} to {max(alone):.4g}"
    told = "all other figures are of the unchanged run"
    assert note == f"it is chaotic: {repeats}, {ends}; {told}"


def test_a_published_design_that_is_not_chaotic_has_one_figure():
    scenario = load_scenario("c-axis-ramp", {"simulation.duration_s": 2.0})
    design = load_design("lin-lee-1999-table-1")
    found = evaluate(design, scenario)
    ends = [1, 63]
    alone = [evaluate(louder_hierarchy(design, FACTORS[k]), scenario).merit for k in ends]
    assert found.repeats["merit"].values[ends] == pytest.approx(alone, rel=1e-9)
    assert alone[0] != alone[1]
    assert not found.chaotic
    assert found.worth == found.merit
    assert {"chaotic", "repeats"}.isdisjoint(found.score(scenario.judge()))
    (_, told), *_ = score_rows(scenario.judge(), [found]).values()
    assert told == f"{found.fitness:.4f}"
    assert notes(scenario, {"it": found}) == []
