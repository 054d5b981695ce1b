"""Constraints that no design keeps: the least violated one is the result, and that is said."""

import json

import numpy as np
import pytest
from run_folders import hfc

from hfc_design.controllers.genome import joined
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.champion import _finalists
from hfc_design.runs.problem import final_problem
from hfc_design.runs.run import finished_run

SMALL = [
    *(
        "controller={kind='pd'}",
        "search.population=16",
        "search.generations=2",
        "simulation.duration_s=0.3",
    ),
    *("fitness.settled_after_s=0.2", "robust.unseen=8", "robust.final=4"),
    *(f"robust.{key}=2" for key in ("first", "machines", "elite")),
]
NEVER = ["constraints.peak_command=0.001", "constraints.late_error='1 nrad'"]  # it has to move


def designed(folder, *changes):
    options = [text for change in (*SMALL, *changes) for text in ("--set", change)]
    return hfc("design", "c-axis-ramp", "--quiet", "--out", folder, *options)


@pytest.mark.usefixtures("no_baselines")
@pytest.mark.parametrize("front", [False, True])
def test_contradictory_constraints(tmp_path, front):
    """Exit code 0, a warning, and the first line of the terminal and of the page say it."""
    trade = ["search.preset=nsga-ii", "search.objectives=['tracking','effort']"]
    done = designed(tmp_path / "run", *NEVER, *(trade if front else []))
    assert done.exit_code == 0, done.output
    assert done.stderr == "hfc: warning: the design is not usable as it is\n"
    told = "no design tried meets every constraint; this one violates them least: the"
    assert " ".join(done.stdout.split()).startswith(f"Can I use it? no: {told} nominal machine ")
    page = (tmp_path / "run" / "report.html").read_text()
    body = page[page.index("<body>") :]
    assert body.index(told) < body.index("<table")
    score = json.loads((tmp_path / "run" / "design.json").read_text())["score"]
    assert score["least_violated"] is True
    if not front:
        scenario, result = finished_run(tmp_path / "run")
        problem, tried = final_problem(scenario), joined(*_finalists(result.search))
        rank = problem.rank_of_finalists(tried)
        assert (rank < 0.0).all()
        own = json.loads((tmp_path / "run" / "design.json").read_text())["controller"]
        least = problem.genome.gains(tried).kp[int(np.argmax(rank))]
        assert own["pd"]["kp"] == pytest.approx(float(least))


@pytest.mark.usefixtures("no_baselines")
def test_constraints_that_can_be_kept_are_not_called_violated(tmp_path):
    done = designed(tmp_path / "run", "constraints.peak_command=1e9")
    assert done.exit_code == 0, done.output
    assert "violates them least" not in done.stdout
    score = json.loads((tmp_path / "run" / "design.json").read_text())["score"]
    assert "least_violated" not in score


@pytest.mark.usefixtures("no_baselines")
def test_a_spread_that_no_machine_survives(tmp_path):
    """Where all diverge there is no design: code 1, and the hint names the spread."""
    ranges = "{kp=[1e9,1.001e9],kd=[1e9,1.001e9]}"
    wild = [f"controller.ranges={ranges}", "robust.spread=0.5"]
    wild += ["search.informed=0"]  # else laws would begin it
    done = designed(tmp_path / "run", *wild)
    assert done.exit_code == 1, done.output
    assert done.stderr.startswith("hfc: no design: every individual diverged (")
    assert "; try a smaller robust.spread; try a larger " in done.stderr
    assert done.stderr.count("\n") == 1
    assert load_scenario(str(tmp_path / "run" / "config.toml")).robust.spread == 0.5
