"""One object judges closed loops: in searches, in the final choice, in scores and in reports."""

import jax.numpy as jnp
import numpy as np
import pytest
from calm import CALM, SMALL, given
from wording import refused

from hfc_design import api
from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.contour import contour
from hfc_design.objectives.judge import Judged, judge
from hfc_design.objectives.lin_lee import lin_lee
from hfc_design.objectives.metrics import metric
from hfc_design.objectives.objective import Moment
from hfc_design.objectives.tolerances import tolerances


def judged(fitness, shares, penalty, positions=(0.0, 0.0, 0.0)):
    """The judge's word on three individuals with such fitness and shares of sticking."""
    sums = np.array(fitness), (np.array(shares) * 50.0, np.full(3, 50.0))
    found = judge(given("given"), penalty).judged(sums, [np.array(positions)])
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
    for key, value in (("worst", "much"), ("best", 1.0)):
        with refused() as told:
            api.load_scenario("c-axis-ramp", {"fitness": {"kind": "weighed", key: value}})
        assert f"fitness.{key} = {value!r}" in told.refusal
    with refused() as told:
        api.load_scenario("c-axis-ramp", {"fitness": {"kind": 5}})
    assert "fitness.kind = 5" in told.refusal


def scored(fitness, moments, stick_penalty=0.0):
    """The merit of samples (error, error_rate, reference_rate, settled)."""
    judging = judge(fitness, stick_penalty)
    sums = judging.initial(np.float64(0.0))
    for error, error_rate, reference_rate, settled in moments:
        sums = judging.update(
            sums, (Moment(error, error_rate, -error, 0.0, reference_rate, settled),), None
        )
    return float(judging.judged(sums, [np.float64(0.0)]).merit)


def test_score_of_equation_5_by_hand():
    moments = [(0.5, -2.0, 0.0, 1.0), (-1.5, 3.0, 0.0, 1.0)]
    assert scored(lin_lee(3.0, 0.1), moments) == pytest.approx(1000 * (3 / 2.0 + 0.1 / 5.0))
    assert scored(lin_lee(2.0, 0.0), moments) == pytest.approx(1000.0)


def test_constraints_of_a_scenario_are_in_the_units_of_its_machine():
    limits = {"late_error": "2 mrad", "chatter": 3, "band_time": "0.5 s", "band": "50 urad"}
    scenario = api.load_scenario({"constraints": limits})
    most = {one.metric.name: one.most for one in scenario.ensemble.constraints}
    assert most == pytest.approx({"late_error": 2e-3, "chatter": 3.0, "band_time": 0.5})
    feed = {"plant": {"name": "feed-drive"}, "simulation": {"sample_time_s": 0.01}}
    feed |= {"controller": {"kind": "pid"}, "constraints": {"late_error": "20 um"}}
    (late,) = api.load_scenario(feed).ensemble.constraints
    millimetres = api.load_scenario(feed).plant.each()[0].length
    assert late.most == pytest.approx(0.02 / millimetres)


def told(scenario, *names):
    search = f"search={{preset='nsga-ii', objectives={[*names]}}}"
    found = load_scenario(scenario, [search])
    return [(one.name, one.unit, one.metric and one.metric.name) for one in found.traded]


def test_tracking_is_what_the_scenario_tolerates_of_an_error():
    assert told("c-axis-ramp", "tracking", "effort") == [
        ("tracking", "rad", "rms_error"),
        ("effort", "V", "rms_command"),
    ]
    assert told("c-axis-practical", "chatter", "tracking") == [
        ("chatter", "V", "chatter"),
        ("tracking", "rad", "settled_rms_error"),
    ]
    assert told("feed-drive-circle", "tracking", "effort", "iae") == [
        ("tracking", "BLU", "estimated_rms_contour_error"),
        ("effort", "unit", "rms_command"),
        ("iae", "BLU s", "iae"),
    ]


def test_sticking_takes_its_share_of_the_score():
    """Stuck is an error rate between 0.9 and 1.1 of the commanded 1 rad/s; the first is early."""
    rates = [1.0, 0.95, 0.0, 1.05, 1.2]
    moments = [(1.0, rate, 1.0, float(k > 0)) for k, rate in enumerate(rates)]
    plain = 1000 * (3 / 5 + 0.1 / sum(rates))
    assert scored(lin_lee(), moments, 4.0) == pytest.approx(plain / (1 + 4 * 0.5))
    assert scored(lin_lee(), moments, 0.0) == pytest.approx(plain)


@pytest.mark.parametrize(
    ("objective", "half"),
    [(tolerances(((metric("rms_error"), 0.5, 1.0),)), 2.0), (lin_lee(3.0, 0.0), 12000.0)],
)
def test_an_axis_without_any_error_is_finite_and_better_than_any_other(objective, half):
    """That which friction holds: 1 / 0 would be taken for a loop that diverges."""

    def fitness(error):
        moment = Moment(*[jnp.zeros(())] * 6, sample_time=1e-3)._replace(error=jnp.asarray(error))
        sums = objective.update(objective.initial(jnp.zeros(())), (moment,), None)
        return float(objective.score(sums))

    assert fitness(0.25) == pytest.approx(half)  # half the target; 3 * 1000 / 0.25
    assert np.isfinite(fitness(0.0))
    assert fitness(0.0) > fitness(1e-5) > fitness(0.25)


def test_a_machine_that_never_leaves_its_path_is_finite():
    still, count = jnp.zeros(()), jnp.asarray(5.0)
    assert np.isfinite(float(contour().score((still, still, still, count))))
