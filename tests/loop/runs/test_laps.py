"""A search that starts elsewhere while the answer is no."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from hfc_design import api
from hfc_design.runs import champion
from hfc_design.runs import run as runs
from hfc_design.runs.champion import TRIAL, lap_of
from hfc_design.runs.run import CONFIG, KEPT, new_run, run
from hfc_design.simulation.acceptance import NO, YES

SCENARIO = {
    "simulation.duration_s": 0.3,
    "controller": {"kind": "pd"},
    "robust": {"spread": 0.01, **{"first": 2, "machines": 2, "elite": 2, "final": 12}},
    "search": {"preset": "cma", "population": 6, "generations": 8},
}


class Use(NamedTuple):
    """An answer that is never yes."""

    good: Any = np.arange(20) < 19
    yes: bool = False
    verdict: str = NO

    def numbers(self):
        return dict.fromkeys(KEPT) | {"verdict": self.verdict, "answer": "not quite"}


def answered_by(monkeypatch, use):
    for module in (champion, runs):
        monkeypatch.setattr(module, "usable", use)


def test_three_laps_and_one_that_was_stopped_in_between(tmp_path, monkeypatch):
    """Each starts elsewhere, as often as it may; stopped before the third the same comes out."""
    answered_by(monkeypatch, lambda design, scenario, seed=None: Use())
    scenario, told = api.load_scenario("c-axis-ramp", SCENARIO), []
    whole, part = tmp_path / "whole", tmp_path / "part"

    def stopped(lap):
        if lap.number == 1:
            raise KeyboardInterrupt

    run(new_run(scenario, whole), whole, on_lap=told.append)
    assert [lap.number for lap in told] == [0, 1]
    own = new_run(scenario, part)
    with pytest.raises(KeyboardInterrupt):
        run(own, part, on_lap=stopped)
    assert not (part / "checkpoint-3.npz").exists()
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

    answered_by(monkeypatch, use)
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


def test_a_lap_is_the_scenario_with_another_seed():
    scenario = api.load_scenario("c-axis-practical")
    other = lap_of(scenario, 2)
    assert other.run == scenario.run.model_copy(update={"seed": scenario.run.seed + 2 * 2**34})
    assert other.model_copy(update={"run": scenario.run}) == scenario
