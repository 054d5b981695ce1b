"""A scenario without a controller, on a machine that the default one does not fit."""

from wording import refused

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import genome_of
from hfc_design.runs.problem import check_memory
from hfc_design.simulation.evaluating import evaluate

MOVE = {
    "name": "move",
    "plant": {"name": "positioning-stage"},
    "reference": {"kind": "step", "height": 0.5},
    "simulation": {"duration_s": 0.1},
}


def test_designs_run_on_it_and_a_search_says_what_is_missing():
    scenario = load_scenario(MOVE)
    assert not evaluate(load_design("emps-cascade"), scenario).diverged
    for asks in (genome_of, check_memory):
        with refused():
            asks(scenario)


def test_a_controller_that_is_named_has_to_fit_at_once():
    with refused():
        load_scenario(MOVE | {"controller": {"kind": "pd+hierarchical-fuzzy"}})
