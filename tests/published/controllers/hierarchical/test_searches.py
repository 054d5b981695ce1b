"""A hierarchy that goes from one linear law to another: what a search makes of it."""

import json

import made_up
import numpy as np
import pytest
from hierarchies import valid
from populations import trajectory
from resuming import whole_and_in_parts
from scheduled import SMALL, of_two_laws
from sledge import hfc

from hfc_design import api
from hfc_design.controllers.hierarchical.seed_laws import Laws
from hfc_design.files.design import design_json
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import design_with, genome_of
from hfc_design.runs.problem import Problem
from hfc_design.simulation import population as simulate
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.evaluating import evaluate


@pytest.mark.parametrize("preset", ["cma", "race"])
def test_stopped_and_resumed_equals_uninterrupted(preset, tmp_path, no_baselines, known_use):
    """Stopped in the stage of two laws; cma ends with a law that is scheduled."""
    own = of_two_laws().controller.model_dump(mode="json")
    small = {"search.preset": preset, **SMALL, "search.generations": 12}
    scenario = api.load_scenario("c-axis-ramp", {"controller": own, **small})
    whole_and_in_parts(scenario, tmp_path, 7)
    own = json.loads((tmp_path / "whole" / "design.json").read_text())["controller"]
    assert own["scheduled"]["kp"] != 0.0


def test_six_inputs_have_4374990_valid_genes():
    numbers = np.arange(16**6, dtype=np.int32).reshape(16, -1)
    good = 0
    for chunk in numbers:
        digits = [(chunk >> shift) & 15 for shift in range(20, -1, -4)]
        good += np.count_nonzero(valid(np.stack(digits, axis=1).astype(np.int8)))
    assert good == 4_374_990


def test_a_search_moves_them(tmp_path, no_baselines, known_use):
    """All stages of cma of two laws, and the page at its end."""
    own = {
        "inputs": [{"name": name, "scale": 50.0} for name in ("reference_rate", "error")],
        "linear": {"load_frequencies_rad_s": [1.0, 50.0]},
        "schedules": True,
    }
    small = {"simulation.duration_s": 0.2, "search.population": 8, "search.generations": 6}
    changes = {"controller": own, "search.preset": "cma", **small}
    scenario = api.load_scenario("c-axis-ramp-cutting", changes)
    genome = genome_of(scenario)
    (first,) = genome.gains(genome.empty()).linear.resonators[:1, 0, 0]
    found = api.design(scenario, tmp_path / "run").design.controller
    assert found.linear.resonators[0].in_phase not in (0.0, first)
    page = (tmp_path / "run" / "report.html").read_text()
    assert f"{found.linear.resonators[1].quadrature:.6g}" in page
    assert "scheduled: resonator of 50 rad/s, quadrature" in page


def test_a_law_in_the_loop_is_a_linear_controller():
    """Without inertia, constant and limit: as an lqr of the same gains in a design file."""
    scenario = load_scenario("c-axis-ramp", ["simulation.duration_s=0.5"])
    problem = Problem(scenario)
    laws = problem.genome.laws()
    numbers = np.array([[900.0, 100.0, 50.0, 5.0, 0.0, 0.0]])
    loop = closed_loop(scenario, laws.controller())
    gains = laws.gains(Laws(np.zeros(1, int), numbers))
    machines = simulate.one_machine(scenario.plant.values())
    judged, _ = trajectory(loop, machines, scenario.samples(), gains)
    signals = {"deflection": 50.0, "deflection_rate": 5.0}
    record = {"kind": "lqr", "kp": 900.0, "kd": 100.0, "ki": 0.0, "signals": signals}
    ahead = {"velocity": 0.0, "acceleration": 0.0, "coulomb": 0.0, "coulomb_width": 1.0}
    design = design_with({**record, "feed_forward": ahead, "weights": {}}, scenario)
    assert judged.values[0, 0] == pytest.approx(evaluate(design, scenario).fitness, rel=1e-9)


def test_without_exp_the_factor_s_deviation_is_told(tmp_path):
    (tmp_path / "design.json").write_text(design_json(made_up.scheduling(7)))
    arguments = (tmp_path / "design.json", "--to", "c", "--out", tmp_path / "c", "--lookup", 33)
    told, command, _ = hfc("export", *arguments).stdout.splitlines()
    assert told.startswith("largest deviation from the exact factor of the scheduled law: ")
    assert "V" not in told
    assert " V at most" in command
    (source,) = (tmp_path / "c").glob("*.c")
    assert "factor of the scheduled law that a search found" in source.read_text()
