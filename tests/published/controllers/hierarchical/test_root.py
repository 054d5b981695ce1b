"""The root that adapts: by hand, against a plain transcription, its bounds, the design file."""

import json

from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.controllers.hierarchical.root import Adaptation
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.simulation.evaluating import evaluate


def adapting(name, **adaptation):
    """A built-in design with the record ``adaptation``, by way of its file."""
    data = json.loads(design_json(load_design(name)))
    data["controller"]["adaptation"] = adaptation
    return parse_design(json.dumps(data), "mine.json")


def test_a_search_designs_the_loop_that_adapts(tmp_path, no_baselines, known_use):
    small = ["simulation.duration_s=0.2", "search.population=16", "search.generations=2"]
    small.append("search.newton_islands=0")  # their derivatives take long to compile
    inputs = "controller.inputs=[{name='error',scale=50.0},{name='deflection',scale=80.0}]"
    adaptation = "controller.adaptation={k_c=1e-3,largest_move=0.5,error_scale=500.0}"
    folder = tmp_path / "run"
    options = [part for change in [*small, inputs, adaptation] for part in ("--set", change)]
    done = CliRunner().invoke(main, ["design", "c-axis-ramp", "--out", str(folder), *options])
    assert done.exit_code == 0, done.output
    assert "largest move" in (folder / "report.html").read_text()
    found = load_design(str(folder))
    wanted = Adaptation(k_c=1e-3, largest_move=0.5, error_scale=500.0)
    assert found.controller.adaptation == wanted
    assert evaluate(found, own_scenario(found, str(folder))).fitness == found.score["fitness"]


def test_a_published_table_learns_a_load_it_was_not_made_for(tmp_path):
    """The no-load table under the cutting load, by the commands."""

    def fitness(design):
        arguments = ["score", str(design), "--scenario", "c-axis-ramp-cutting", "--json"]
        done = CliRunner().invoke(main, arguments)
        assert done.exit_code == 0, done.output
        return json.loads(done.stdout)["fitness"]

    path = tmp_path / "mine.json"
    path.write_text(design_json(adapting("lin-lee-1999-table-1", k_c=1e-2, largest_move=2.0)))
    assert fitness(path) > 2.0 * fitness("lin-lee-1999-table-1")
    csv = tmp_path / "motion.csv"
    done = CliRunner().invoke(main, ["simulate", str(path), "--csv", str(csv)])
    assert done.exit_code == 0, done.output
    assert len(csv.read_text().splitlines()) == 10_001
