"""One object judges closed loops: in searches, in the final choice, in scores and in reports."""

import numpy as np
import pytest
from calm import CALM, SMALL, TITLE
from wording import refused

from hfc_design import api
from hfc_design.controllers.gains.genome import GainVectors
from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.verdict import Ensemble
from hfc_design.runs import champion
from hfc_design.search.loop import Archive, Search


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
    _, design, found = next(champion.best_of(search, scenario))
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
        pytest.param(CALM._replace(settings=dict), id="settings that are none"),
        pytest.param(CALM._replace(name=""), id="no name"),
        pytest.param(3, id="a number"),
    ],
)
def test_an_objective_that_lacks_something_is_refused(objective, own_plugins):
    with refused():
        api.register(objective)


SEARCH = "search={{preset='nsga-ii', objectives={}}}"


def told(scenario, *names, changes=()):
    found = load_scenario(scenario, [SEARCH.format([*names]), *changes])
    return [(one.name, one.unit, one.metric and one.metric.name) for one in found.traded]


@pytest.mark.parametrize(
    "names",
    [
        ["tracking"],
        ["iae", "iae"],
        ["tracking", "rms_error"],
        ["tracking", "estimated_rms_contour_error"],
        ["tracking", "band_time"],
    ],
)
def test_what_cannot_be_traded_is_told_in_a_line(names):
    with refused() as found:
        told("c-axis-ramp", *names)
    assert "search.objectives" in found.refusal
    assert "\n" not in found.refusal


def test_only_hierarchies_have_units():
    with refused() as found:
        told("c-axis-ramp", "tracking", "units", changes=["controller={kind='pd'}"])
    assert "search.objectives" in found.refusal


def test_costs_are_means_of_motions_and_of_machines_what_is_kept():
    values = np.array([[[[1.0], [4.0]], [[3.0], [8.0]]]])  # motions (1, 4) and (3, 8)
    mean = [(1 + 2 * 4) / 3, (3 + 2 * 8) / 3]
    assert Ensemble((1.0, 2.0)).costs(values) == pytest.approx(np.array([[sum(mean) / 2]]))
    assert Ensemble((1.0, 2.0), keep="worst").costs(values) == pytest.approx(max(mean))
    assert Ensemble((1.0, 2.0), keep="quantile").costs(values) == pytest.approx(max(mean))


def test_overshoot_on_a_program_is_beyond_every_reversal(tmp_path):
    """X turns round at 6 mm and ends at 0; before it does so, nothing is beyond."""
    (tmp_path / "there.ngc").write_text("G1 X6 F6000\nX0\n")
    limits = {axis: {"acceleration_per_s2": 800.0} for axis in "xyzac"}
    scenario = {
        "plant": {"name": "five-axis"},
        "reference": {"kind": "gcode", "file": str(tmp_path / "there.ngc"), "limits": limits},
        "simulation": {"duration_s": 0.5, "sample_time_s": 0.002},
        "controller": {"kind": "pid"},
    }
    x, y = load_scenario(scenario).samples().axes[:2]
    turn, stands = int(x.target.argmax()), x.target == 0.0
    assert not x.heading[:turn].any()
    assert x.end[turn:] == pytest.approx(np.where(stands[turn:], 0.0, 6.0), abs=1e-3)
    assert (x.heading[turn:] == np.where(stands[turn:], -1.0, 1.0)).all()
    assert not y.heading.any()  # it never moves
