"""One object judges closed loops: in searches, in the final choice, in scores and in reports."""

import jax.numpy as jnp
import numpy as np
import pytest

from hfc_design import api
from hfc_design.controllers.gains.genome import GainVectors
from hfc_design.objectives.judge import judge
from hfc_design.objectives.lin_lee import lin_lee
from hfc_design.runs import champion
from hfc_design.search.loop import Archive, Search

TITLE = "fitness, LL eq. 5 / (1 + 300 stick share)"
#: In 0.3 s, with a PD part alone; a large derivative gain diverges.
SMALL = {
    "simulation.duration_s": 0.3,
    "search.population": 16,
    "search.generations": 6,
    "controller": {"kind": "pd", "ranges": {"kd": [30.0, 1e8]}},
}
#: Below zero: minus the largest error in mrad; and one that is never a number.
CALM = api.Objective(
    lambda zero: zero,
    lambda sums, moments, path: jnp.maximum(sums, jnp.abs(moments[0].error)),
    lambda sums: -1000.0 * sums,
    name="calm",
    title="largest error",
    unit="mrad",
)


def one(sums):
    """An objective that is given."""
    return api.Objective(lambda zero: zero, lambda s, moments, path: s, lambda s: s, name=sums)


def test_what_a_judge_is_called():
    plain, hard = judge(lin_lee(), 0.0), judge(lin_lee(), 300.0)
    assert plain.titles == {"fitness": "fitness, LL eq. 5"}
    assert hard.titles == {"fitness": "fitness, LL eq. 5", "merit": TITLE}
    worse = "largest error, worse by the factor (1 + 2.5 stick share) [mrad]"  # below zero too
    assert judge(CALM, 2.5).title == worse
    never_below = CALM._replace(positive=True)
    assert judge(never_below, 2.5).title == "largest error / (1 + 2.5 stick share) [mrad]"
    assert judge(one("mine"), 0.0).title == "fitness, mine"
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
    ("objective", "words"),
    [
        (CALM._replace(update=None), ["fitness 'calm'", "update = None: has to be a function"]),
        (CALM._replace(score=1.0), ["fitness 'calm'", "score = 1.0: has to be a function"]),
        (CALM._replace(settings=dict), ["fitness 'calm'", "settings", "ObjectiveSettings"]),
        (CALM._replace(name=""), ["fitness ''", "a name has letters"]),
        (CALM._replace(name="stick-share"), ["'stick-share' is built in"]),
        (object(), ["none of", "fitness", "plant"]),
    ],
)
def test_an_objective_that_lacks_something(objective, words, own_plugins):
    with pytest.raises(api.UserError) as error:
        api.register(objective)
    for word in words:
        assert word in str(error.value)
