"""A motion that diverges is simulated in finer steps, and says when and what ran away."""

import json

import pytest
from ovens import OVEN, baking
from sledge import hfc as command

import hfc_design.api as hfc
from hfc_design.files.design import design_json

#: Where classical Runge-Kutta steps stop being stable for a real decay, rate times step.
LIMIT = 2.785


@pytest.fixture
def oven(own_plugins):
    hfc.register(OVEN)
    return baking


def simulated(found, kp=100.0):
    return hfc.evaluate(hfc.with_gains(found, "pd", {"kp": kp, "kd": 20.0}), found)


@pytest.mark.parametrize(("rate", "substeps"), [(2700.0, 1), (5000.0, 4), (20000.0, 16)])
def test_steps_become_finer_until_they_are_stable(oven, rate, substeps):
    assert rate * 1e-3 / substeps < LIMIT < (rate * 1e-3 / (substeps / 4) if substeps > 1 else 3.0)
    found = simulated(oven(cools=rate))
    assert not found.diverged
    assert found.substeps == substeps
    assert found.divergence is None
    assert found.fitness == pytest.approx(simulated(oven()).fitness, rel=1e-12)


def test_what_diverges_in_all_of_them_says_when_and_what(oven):
    found = simulated(oven(burns=2.0))  # its flame is 1 / (1 - 2 t)
    assert found.diverged
    assert found.substeps == 16
    assert found.divergence.cause == "flame"
    assert found.divergence.time_s == pytest.approx(0.5, abs=0.002)
    found = simulated(oven(cools=1e6))
    assert found.divergence.cause == "heat"
    assert found.divergence.time_s < 0.01


def test_many_designs_at_once_are_mended_one_by_one(oven):
    where = oven(cools=5000.0)
    gains = [{"kp": 100.0, "kd": 20.0}, {"kp": 1.7e308, "kd": 20.0}, {"kp": 50.0, "kd": 20.0}]
    designs = [hfc.with_gains(where, "pd", own) for own in gains]
    machines = [{}, {"cools": 0.0}, {"burns": 2.0}]
    judged = hfc.evaluate_many(designs, where, machines)
    assert judged.failed[:, 0].tolist() == [[False, False, True], [True] * 3, [False, False, True]]
    for k in (0, 2):
        alone = hfc.evaluate(designs[k], where).fitness
        assert judged.fitness[k, 0, :2] == pytest.approx(alone, rel=1e-12)


def test_the_command_line_says_it(oven, tmp_path):
    calm, lost = tmp_path / "calm.json", tmp_path / "lost.json"
    for path, kp in ((calm, 100.0), (lost, 1.7e308)):
        path.write_text(design_json(hfc.with_gains(oven(), "pd", {"kp": kp, "kd": 20.0})))
    done = command("score", lost)
    assert done.exit_code == 0, done.output
    assert "bakes diverges: " in done.stdout
    assert " s, also with 16 substeps" in done.stdout
    told = json.loads(command("score", lost, "--json").stdout)
    assert told["substeps"] == 16
    assert 0.0 <= told["divergence"]["time_s"] <= 0.6
    assert told["divergence"]["cause"] == "the command"
    done = command("simulate", lost)
    assert "bakes diverges: " in done.stderr
    assert done.stdout.startswith("time_s,")
    fine = json.loads(command("score", calm, "--json").stdout)
    assert (fine["substeps"], fine["divergence"]) == (1, None)


def test_a_command_that_is_no_number_is_named(oven):
    found = simulated(oven(), kp=1.7e308)
    assert found.divergence.cause == "the command"
