"""A polished run: what it brings, that no interruption changes it, and what is refused."""

import json
import tomllib

import numpy as np
import pytest
import short_runs
from populations import trajectory
from short_runs import contents

from hfc_design.controllers.genome import taken
from hfc_design.core.records import RunError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import polishing, run
from hfc_design.runs.polishing import PolishTask
from hfc_design.runs.problem import Problem
from hfc_design.search.polish import polish
from hfc_design.simulation import population as simulate
from hfc_design.simulation.error_weights import Traces, motion_slopes
from hfc_design.simulation.evaluating import evaluate

SMALL = ["simulation.duration_s=0.1", "search.population=24", "search.generations=9"]
POLISHED = [*SMALL, "run.polish=6"]


def started(folder, changes=POLISHED):
    return short_runs.started(folder, small=changes)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("polished") / "whole"
    steps = []
    result = run.run(started(folder), folder, on_polish=lambda done: steps.append(done.step))
    assert steps == [1, 2, 3, 4, 5, 6]
    return folder, result


def test_a_polish_is_told_and_ends_better_than_the_search(whole, tmp_path, known_use):
    folder, result = whole
    plain = run.run(started(tmp_path / "plain", SMALL), tmp_path / "plain")
    assert result.evaluation.merit > plain.evaluation.merit
    told = json.loads((folder / "design.json").read_text())["score"]["polish"]
    assert told["steps"] == 6
    assert told["before"] == pytest.approx(plain.evaluation.merit, rel=1e-9)
    assert told["after"] == pytest.approx(result.evaluation.merit, rel=1e-9)
    found = result.design
    assert evaluate(found, run.opened_run(folder)).merit == result.evaluation.merit
    line = f"polish: 6 steps, merit from {told['before']:.5g} to {told['after']:.5g}"
    assert polishing.polish_told(found) == line
    assert polishing.polish_told(plain.design) == ""
    config = tomllib.loads((tmp_path / "plain" / "config.toml").read_text())
    assert "polish" not in config["run"]


@pytest.mark.parametrize("stop", [1, 6])
def test_interrupted_and_resumed_equals_uninterrupted(whole, tmp_path, stop):
    part = tmp_path / "part"
    scenario = started(part)

    def interrupt(done):
        if done.step == stop:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run.run(scenario, part, on_polish=interrupt)
    assert not (part / "design.json").exists()
    begun = []
    run.run(run.opened_run(part), part, on_polish=lambda done: begun.append(done.step))
    assert begun == [*range(stop + 1, 7)]
    assert contents(part) == contents(whole[0])


def test_damaged_or_foreign_checkpoints_are_refused_and_left_alone(whole, tmp_path):
    part = tmp_path / "part"
    part.mkdir()
    for name in ("config.toml", "checkpoint.npz"):
        (part / name).write_bytes((whole[0] / name).read_bytes())
    good = (whole[0] / "polish.npz").read_bytes()
    for bad in (good[:-1], b"", (whole[0] / "checkpoint.npz").read_bytes()):
        (part / "polish.npz").write_bytes(bad)
        with pytest.raises(RunError, match=r"polish\.npz: is damaged"):
            run.run(run.opened_run(part), part)
        assert (part / "polish.npz").read_bytes() == bad
    other = tmp_path / "other"
    scenario = started(other, [*POLISHED, "run.seed=5"])
    (other / "polish.npz").write_bytes(good)
    with pytest.raises(RunError, match=r"another config\.toml"):
        run.run(scenario, other)


@pytest.mark.parametrize(
    ("scenario", "fitness"),
    [
        ("c-axis-ramp", {}),
        (
            "c-axis-ramp-cutting",
            {
                "fitness.kind": "tolerances",
                "fitness.settled_after_s": 0.1,
                "fitness.tolerances": {"settled_rms_error": 1e-4, "chatter": 4.0, "iae": 1e-3},
            },
        ),
    ],
)
def test_slopes_of_the_merit_are_those_of_the_formula(scenario, fitness):
    """Of LL eq. 5 and of a mean of tolerances, by hand with NumPy."""
    where = load_scenario(scenario, {"simulation.duration_s": 0.25, **fitness})
    problem = Problem(where)
    one = taken(problem.genome.fresh(np.arange(3), np.random.default_rng(1)), slice(1))
    loop, machines, (samples,) = problem.loop, problem.machines, problem.motions
    gains = problem.genome.gains(one)
    judged, (motion,) = trajectory(loop, machines, samples, gains)
    e, rate, u = (x[:, 0] for x in (motion.error, motion.error_rate, motion.command))
    merit, slopes = motion_slopes(loop, samples, Traces(e, rate, u, np.diff(u, prepend=0.0)))
    assert merit == pytest.approx(judged.merit[0], rel=1e-12)
    worse = judged.merit[0] / judged.values[0, 0]  # by sticking, which jumps
    if not fitness:
        expected = [
            -3000.0 * worse * np.sign(e) / np.abs(e).sum() ** 2,
            -100.0 * worse * np.sign(rate) / np.abs(rate).sum() ** 2,
            0.0 * u,
            0.0 * u,
        ]
    else:
        settled = samples.settled
        rms = np.sqrt((settled * e**2).sum() / settled.sum())
        change = np.diff(u, prepend=0.0)
        chatter = np.sqrt((change**2).mean())
        by_error = settled * e / (settled.sum() * rms) / 1e-4 / 3.0
        by_error = by_error + 0.001 * np.sign(e) / 1e-3 / 3.0
        by_change = change / (len(u) * chatter) / 4.0 / 3.0
        expected = [-(merit**2) * x for x in (by_error, 0.0 * rate, 0.0 * u, by_change)]
    traces = (e, rate, u, u)
    for found, hand, value in zip(slopes, expected, traces, strict=True):
        some = value != 0.0  # where a magnitude has a derivative
        np.testing.assert_allclose(found[some], hand[some], rtol=1e-9, atol=1e-9 * abs(hand).max())


def test_derivatives_go_through_encoders_and_converters():
    """Their own is 0: what a law does about an error would not be seen, nor any command."""
    changes = {"simulation.duration_s": 0.2, "controller.kind": "lqi"}
    changes |= {"sensors.encoder_resolution": 3e-6, "limits.resolution": 0.05}
    changes |= {"sensors.velocity": "observer", "sensors.observer_hz": 80.0}
    where = load_scenario("c-axis-ramp", changes)
    problem = Problem(where)
    one = problem.genome.empty()
    loop, machines, (samples,) = problem.loop, problem.machines, problem.motions
    gains = problem.genome.gains(one)
    about = (machines, samples, gains, ("error",), np.float64)
    _, stepped = simulate.jacobians(loop, *about)["error"]
    assert not stepped.any()
    error, jacobian = simulate.jacobians(loop.smooth, *about)["error"]
    # The central difference of the loop as it is, over changes that encoders can see.
    for k, name in ((0, "kp"), (2, "kd")):
        moved = []
        for factor in (1.1, 0.9):
            other = gains._replace(**{name: factor * getattr(gains, name)})
            moved.append(trajectory(loop, machines, samples, other)[1][0].error[:, 0])
        change = moved[0] - moved[1]
        assert np.abs(change).max() > 10 * 3e-6
        predicted = 0.2 * getattr(gains, name) * jacobian[:, k]
        assert np.abs(predicted - change).max() < 0.2 * np.abs(change).max()
    assert np.abs(error).max() > 1e-4


def test_normal_equations_of_many_machines_lead_downhill():
    """A law in the middle of all ranges is far from what it can be."""
    changes = {"simulation.duration_s": 0.3, "robust.final": 6, "robust.first": 2}
    changes |= {"robust.machines": 2, "robust.elite": 2, "fitness.kind": "tolerances"}
    changes |= {"controller.kind": "pid+ff", "search.preset": "cma"}
    scenario = load_scenario("c-axis-ramp", changes)
    problem = Problem(scenario)
    one = problem.genome.empty()
    task = PolishTask(scenario, one).task
    *_, last = polish(task, one, 8, 0)
    assert last.worth[0, 0] > 1.5 * last.first[0, 0]
    assert task.worth(last.population) == pytest.approx(last.worth, rel=1e-12)
