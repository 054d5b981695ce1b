"""A search that goes on while the answer is no, and how: from where it was, or elsewhere."""

from itertools import chain, repeat
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

from hfc_design import api
from hfc_design.runs import run as runs
from hfc_design.runs.laps import TRIAL, Lap, lap_of
from hfc_design.runs.problem import Problem
from hfc_design.runs.run import CONFIG, KEPT, new_run, run
from hfc_design.simulation.in_use import NO, ON_THIS_MODEL, YES

SCENARIO = {
    "simulation.duration_s": 0.3,
    "controller": {"kind": "pd"},
    "robust": {"spread": 0.01, **{"first": 2, "machines": 2, "elite": 2, "final": 12}},
    "search": {"preset": "cma", "population": 6, "generations": 8},
}


@pytest.mark.parametrize(
    ("preset", "share", "verdict", "goes_on"),
    [
        ("cma", 0.95, NO, True),
        ("cma", 0.8, NO, False),
        ("cma", 0.95, ON_THIS_MODEL, False),
        ("race", 0.95, NO, False),
    ],
)
def test_it_goes_on_from_what_is_nearly_right(preset, share, verdict, goes_on):
    """If its scores are compared within a generation only; others start elsewhere."""
    changes = {"search.preset": preset, "robust.spread": 0.1, "controller": {"kind": "pd"}}
    scenario = api.load_scenario("c-axis-ramp", changes)
    use = SimpleNamespace(good=np.arange(20) < 20 * share, verdict=verdict)
    assert Lap(0, None, None, None, use).goes_on(scenario) is goes_on


def test_a_lap_that_goes_on_costs_as_much_with_more_machines_at_once():
    scenario = api.load_scenario("c-axis-practical")
    for k in (0, 1, 2):
        other, finer = lap_of(scenario, k), lap_of(scenario, k, finer=True)
        assert other.run.seed == finer.run.seed == scenario.run.seed + k * 2**34
        assert (other.robust, other.search) == (scenario.robust, scenario.search)
        robust, search = finer.robust, finer.search
        assert (robust.first, robust.machines, robust.elite) == (12, 12, 12)
        assert search.generations == scenario.search.generations // 4


class Use(NamedTuple):
    """An answer that is never yes."""

    good: Any = np.arange(20) < 19
    yes: bool = False
    verdict: str = NO

    def numbers(self):
        return dict.fromkeys(KEPT) | {"verdict": self.verdict, "answer": "not quite"}


@pytest.mark.parametrize(("first", "generations"), [(NO, [2, 8]), (ON_THIS_MODEL, [8, 2])])
def test_three_laps_and_one_that_was_stopped_in_between(first, generations, tmp_path, monkeypatch):
    """Where a few machines are missing the next goes on, the one behind that starts elsewhere.

    Where a stress breaks it it does at once. Stopped before the third the same comes out.
    """

    def asked():
        each = chain([Use(verdict=first)] * 3, repeat(Use()))
        monkeypatch.setattr(runs, "usable", lambda design, scenario, seed=None: next(each))

    def problem(scenario, known):
        made.append(known)
        return Problem(scenario, known=known)

    monkeypatch.setattr(runs, "Problem", problem)
    scenario, told, made = api.load_scenario("c-axis-ramp", SCENARIO), [], []
    whole, part = tmp_path / "whole", tmp_path / "part"

    def stopped(lap, where):
        if lap.number == 1:
            raise KeyboardInterrupt

    asked()
    run(new_run(scenario, whole), whole, on_lap=lambda *lap: told.append(lap))
    assert [where.search.generations for _, where in told] == generations
    goes_on = generations.index(2)
    assert [known is not None for known in made] == [False, goes_on == 0, goes_on == 1]
    assert made[goes_on + 1] is told[goes_on][0].found[0]
    own = new_run(scenario, part)
    asked()
    with pytest.raises(KeyboardInterrupt):
        run(own, part, on_lap=stopped)
    asked()
    run(own, part)
    assert (part / "checkpoint-3.npz").exists()
    for name in ("design.json", "usable.json", "history.csv", CONFIG):
        assert (part / name).read_bytes() == (whole / name).read_bytes()


def asked_by(monkeypatch, good):
    """What is asked in the trial and in the answer: design and whether it is yes.

    Of the trial that is so where ``good`` has its number, of the answer from number -1 on.
    """
    trial, answer = [], []

    def use(design, scenario, seed=None):
        assert seed in (None, scenario.run.seed + TRIAL)
        mine = answer if seed is None else trial
        yes = len(trial) in good if seed else -len(answer) - 1 not in good
        mine.append((design, yes))
        return Use(yes=yes, verdict=YES if yes else NO)

    monkeypatch.setattr(runs, "usable", use)
    return trial, answer


@pytest.mark.parametrize("good", [0, 2, 3])
def test_the_first_three_finalists_are_tried_until_one_can_be_used(good, tmp_path, monkeypatch):
    """The first that stands the trial is the design, though another ranks first.

    The answer is asked of that one alone, on other machines.
    """
    trial, answer = asked_by(monkeypatch, [good])
    scenario = api.load_scenario("c-axis-ramp", SCENARIO | {"run.extend": 2})
    result = run(new_run(scenario, tmp_path / "run"), tmp_path / "run")
    assert [yes for _, yes in trial] == [False] * good + [True]
    assert len({repr(one.controller) for one, _ in trial}) == len(trial)
    assert [yes for _, yes in answer] == [True]
    assert result.design.controller == trial[good][0].controller == answer[0][0].controller
    assert result.design.score.get("lap", 0) == good // 3


def test_an_answer_that_is_not_that_of_the_trial_is_no_end(tmp_path, monkeypatch):
    """The next lap is asked, too, and is the design as its answer is yes."""
    trial, answer = asked_by(monkeypatch, [0, 1, -1])
    scenario = api.load_scenario("c-axis-ramp", SCENARIO | {"run.extend": 2})
    result = run(new_run(scenario, tmp_path / "run"), tmp_path / "run")
    assert [yes for _, yes in trial] == [True, True]
    assert [yes for _, yes in answer] == [False, True]
    assert result.design.score["lap"] == 1
    assert result.design.score["usable"]["verdict"] == YES
