"""Own plants, fitnesses and control laws: how they come in, and what they compute."""

import json

import pytest
from sledge import BUDGET, hfc, refused

from hfc_design.files.machine import ALL_PLANTS


def test_a_plant_by_module_reference_is_designed_for_scored_and_exported(own):
    run = own / "run"
    done = hfc("design", "sledge.toml", "--plant", "mine:SLEDGE", "--out", run, *BUDGET)
    assert done.exit_code == 0, done.output
    assert "max_error_m" in done.stdout
    assert (run / "report.html").exists()
    design = json.loads((run / "design.json").read_text())
    assert design["plant"] == {
        "name": "sledge",
        "parameters": {"mass": 2.0, "friction": 3.0},
        "axes": {},
    }
    scored = hfc("score", run, "--plant", "mine:SLEDGE", "--json")
    assert json.loads(scored.stdout)["fitness"] == design["score"]["fitness"]
    done = hfc("export", run, "--to", "json", "--out", "copy.json", "--plant", "mine:SLEDGE")
    assert done.exit_code == 0
    page = (run / "report.html").read_bytes()
    assert "sledge" in refused_without("report", run)
    assert hfc("report", run, "--plant", "mine:SLEDGE").exit_code == 0
    assert (run / "report.html").read_bytes() == page
    again = hfc("design", "--resume", "--out", run, "--plant", "mine:SLEDGE", "--quiet")
    assert again.exit_code == 0, again.output


def refused_without(*arguments):
    """What a command says that is not told of the own plant, as in another process."""
    plant = ALL_PLANTS.known.pop("sledge")
    line = refused(*arguments)
    ALL_PLANTS.known["sledge"] = plant
    return line


def test_own_fitness_and_controller_by_reference(own, known_use):
    options = ("--plant", "mine:SLEDGE", "--fitness", "mine:LAST", "--controller", "mine:P")
    done = hfc("design", "sledge.toml", *options, "--out", "run", *BUDGET)
    assert done.exit_code == 0, done.output
    assert "fitness, last-error" in done.stdout
    design = json.loads((own / "run" / "design.json").read_text())
    assert design["controller"]["kind"] == "only-p"
    (gain,) = design["controller"]["gains"].values()
    assert 1.0 <= gain <= 100.0
    # The fitness is 1 / (0.001 + |last error|), and the last error is a metric.
    score = design["score"]
    assert score["fitness"] == pytest.approx(1.0 / (0.001 + abs(score["final_error_m"])))
    again = json.loads(hfc("score", "run", *options, "--json").stdout)
    assert again["fitness"] == score["fitness"]
    other = hfc("score", "run", *options[:2], *options[4:], "--fitness", "lin-lee", "--json")
    assert json.loads(other.stdout)["fitness"] != score["fitness"]
    table = hfc("score", "run", *options)
    assert "fitness, last-error" in table.stdout
