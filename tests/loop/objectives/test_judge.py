"""One object judges closed loops: in searches, in the final choice, in scores and in reports."""

import jax.numpy as jnp
import numpy as np
import pytest

from hfc_design import api
from hfc_design.objectives.judge import Judged, judge

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


def judged(fitness, shares, penalty, positions=(0.0, 0.0, 0.0)):
    """The judge's word on three individuals with such fitness and shares of sticking."""
    sums = np.array(fitness), (np.array(shares) * 50.0, np.full(3, 50.0))
    found = judge(one("given"), penalty).judged(sums, [np.array(positions)])
    return Judged(*map(np.asarray, found))


def test_merit_by_hand():
    """A tenth of the time at a penalty of 20 costs a factor of three, whatever the sign."""
    found = judged([9.0, -9.0, 0.0], [0.1, 0.1, 0.1], 20.0)
    assert found.merit == pytest.approx([3.0, -27.0, 0.0])
    assert found.values[:, 0].tolist() == [9.0, -9.0, 0.0]
    assert found.values[:, 1] == pytest.approx([-2.0, -2.0, -2.0])
    assert not found.failed.any()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_position_or_an_objective_that_is_no_number_fails_and_ranks_last(bad):
    found = judged([bad, -1e30, 1.0], [0.0, 0.0, 0.0], 20.0, positions=[0.0, 0.0, bad])
    assert found.failed.tolist() == [True, False, True]
    assert found.rank.tolist() == [-np.inf, -1e30, -np.inf]


class Weighed(api.ObjectiveSettings):
    worst: float = 1.0


def test_an_own_objective_has_weights_of_its_own(own_plugins):
    """And a wrong one is told by its key."""

    def weighed(own):
        return CALM._replace(score=lambda sums: -own.worst * sums)

    api.register(CALM._replace(name="weighed", settings=Weighed, make=weighed))
    scenario = api.load_scenario(
        "c-axis-ramp", {**SMALL, "fitness": {"kind": "weighed", "worst": 5.0}}
    )
    design = api.with_gains(scenario, "pd", {"kp": 900.0, "kd": 700.0})
    found = api.evaluate(design, scenario)
    assert found.fitness == pytest.approx(-5.0 * found.metrics["max_error_rad"], rel=1e-9)
    assert scenario.model_dump()["fitness"] == {
        "kind": "weighed",
        "worst": 5.0,
        "settled_after_s": 1.0,
    }
    for changes, words in (
        ({"kind": "weighed", "worst": "much"}, "fitness.worst = 'much'"),
        ({"kind": "weighed", "best": 1.0}, "fitness.best = 1.0"),
        ({"kind": 5}, "fitness.kind = 5"),
    ):
        with pytest.raises(api.UserError, match=words):
            api.load_scenario("c-axis-ramp", {"fitness": changes})
