"""One object judges closed loops: in searches, in the final choice, in scores and in reports."""

import numpy as np
import pytest
from calm import CALM, SMALL, TITLE, given
from wording import refused

from hfc_design import api
from hfc_design.controllers.gains.genome import GainVectors
from hfc_design.objectives.judge import judge
from hfc_design.objectives.lin_lee import lin_lee
from hfc_design.runs import champion
from hfc_design.search.loop import Archive, Search


def test_what_a_judge_is_called():
    plain, hard = judge(lin_lee(), 0.0), judge(lin_lee(), 300.0)
    assert plain.titles == {"fitness": "fitness, LL eq. 5"}
    assert hard.titles == {"fitness": "fitness, LL eq. 5", "merit": TITLE}
    worse = "largest error, worse by the factor (1 + 2.5 stick share) [mrad]"  # below zero too
    assert judge(CALM, 2.5).title == worse
    never_below = CALM._replace(positive=True)
    assert judge(never_below, 2.5).title == "largest error / (1 + 2.5 stick share) [mrad]"
    assert judge(given("mine"), 0.0).title == "fitness, mine"
    assert judge(lin_lee(), 300.0) is hard  # one compiled program


def test_the_final_choice_is_by_merit(monkeypatch):
    """Hand-made results: the highest fitness belongs to one that sticks."""
    results = {0.1: (50.0, 5.0), 0.2: (20.0, 20.0), 0.3: (-np.inf, -np.inf)}
    scenario = api.load_scenario("c-axis-ramp", SMALL)

    def evaluated(design, where):
        place = round((np.log(design.controller.pd.kp) - np.log(100.0)) / np.log(100.0), 6)
        fitness, merit = results[place]
        common = (not np.isfinite(merit), None, {}, np.empty(0), (), None)
        return api.Evaluation(fitness, merit, *common)

    def population(*kp):
        return GainVectors(np.zeros(len(kp), int), np.array([[place, 0.5] for place in kp]))

    monkeypatch.setattr(champion, "evaluate", evaluated)
    archive = Archive(population(0.1), np.array([5.0]))
    search = Search(3, Archive(population(0.3, 0.2), np.array([7.0, 6.0])), archive, None)
    design, found = champion.champion(search, scenario)
    assert (found.fitness, found.merit) == (20.0, 20.0)
    assert design.score == {
        "scenario": "c-axis-ramp",
        "fitness": 20.0,
        "merit": 20.0,
        "judged_by": TITLE,
    }


@pytest.mark.parametrize(
    "objective",
    [
        pytest.param(CALM._replace(update=None), id="no update"),
        pytest.param(CALM._replace(score=1.0), id="a score that is a number"),
        pytest.param(CALM._replace(settings=dict), id="settings that are none"),
        pytest.param(CALM._replace(name=""), id="no name"),
        pytest.param(CALM._replace(name="stick-share"), id="a name that is built in"),
        pytest.param(3, id="a number"),
    ],
)
def test_an_objective_that_lacks_something_is_refused(objective, own_plugins):
    with refused():
        api.register(objective)
