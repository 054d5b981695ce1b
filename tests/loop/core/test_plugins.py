"""Own plants, fitnesses and control laws: how they come in, and what they compute."""

import json
from pathlib import Path

import numpy as np
import pytest
from imported_files import GAUSSIAN
from scipy.integrate import solve_ivp
from sledge import api_text, hfc, imported, scenario_of
from wording import refused_command

from hfc_design import api
from hfc_design.formats.reading import Wish
from hfc_design.formats.reading import imported as imported_design


def test_a_batch_knows_an_own_plant(own):
    grid = "[grid]\nscenario = ['sledge.toml']\nrun.seed = [0, 1]\n"
    sizes = "[set]\nsearch.population = 4\nsearch.generations = 1\nsimulation.duration_s = 0.5\n"
    (own / "batch.toml").write_text(sizes + grid)
    refused_command("batch", "batch.toml")
    done = hfc("batch", "batch.toml", "--plant", "mine:SLEDGE", "--out", "out")
    assert done.exit_code == 0, done.output
    assert len(list((own / "out").glob("*/design.json"))) == 2


def design_for_the_sledge(name):
    """The file of a built-in design whose plant is the own one."""
    design = json.loads(api_text(name))
    design["plant"] = {"name": "sledge", "parameters": {}}
    Path("mine.json").write_text(json.dumps(design))
    return "mine.json"


def test_stability_knows_an_own_plant_and_asks_for_its_drive(own):
    file = design_for_the_sledge("jee-koren-2004-flc")
    own_plant = ("--plant", "mine:SLEDGE")
    for options in ((), own_plant, (*own_plant, "--gain", "28.3")):
        refused_command("stability", file, *options)
    drive = ("--gain", "28.3", "--time-constant", "0.055")  # those of the published design
    done = hfc("stability", file, *own_plant, *drive, "--json")
    published = json.loads(hfc("stability", "jee-koren-2004-flc", "--json").stdout)
    assert published.pop("loop")["points"]
    assert json.loads(done.stdout) == published
    # A plant of one's own with the parameters of the feed drive is one.
    (own / "smooth.py").write_text(
        "from dataclasses import replace\nfrom plants import FEED_DRIVE\n"
        "PLANT = replace(FEED_DRIVE, name='sledge')\n"
    )
    assert hfc("stability", file, "--plant", "smooth:PLANT", "--json").stdout == done.stdout
    file = design_for_the_sledge("pd-only")
    refused_command("stability", file, *own_plant)


def test_a_controller_is_imported_for_an_own_plant(own):
    """The loop's first command is the runtime's, of the same file for the C-axis."""
    signals = ("--signal", "deflection=speed")
    command = ("import", GAUSSIAN, "--plant", "mine:SLEDGE", "--out", "mine.json", *signals)
    refused_command(*command)
    done = hfc(*command, "--sample-time", "0.01")
    assert done.exit_code == 0, done.output
    design = json.loads(Path("mine.json").read_text())
    assert design["plant"]["name"] == "sledge"
    assert [item["name"] for item in design["controller"]["inputs"]] == ["speed", "error"]
    done = hfc(
        "simulate",
        "mine.json",
        "--scenario",
        "sledge.toml",
        "--set",
        "reference.height=0.3",
        "--set",
        "simulation.duration_s=2.5",
    )
    names, first, *_ = (line.split(",") for line in done.stdout.splitlines())
    row = dict(zip(names, map(float, first), strict=True))
    assert row["error_m"] == 0.3
    c_axis = api.Controller(imported_design(GAUSSIAN, Wish()))
    told = c_axis.step({"error": 0.3, "error_rate": 0.0, "deflection": 0.0})
    assert row["command_N"] == pytest.approx(told, abs=1e-12)
    assert abs(told) > 0.1
    # What --like takes from a design for the plant, the sample time among it, need not be said.
    again = hfc("import", GAUSSIAN, "--like", "mine.json", "--name", "again", *signals)
    assert again.exit_code == 0, again.output
    assert json.loads(Path("again.json").read_text())["controller"] == design["controller"]
    refused_command(*command[:6], "--force", "--sample-time", "0.01")
    refused_command("import", GAUSSIAN, "--plant", "rocket")


def test_the_loop_of_an_own_plant_is_that_of_scipy(own):
    """A PD law held over each sample is a piecewise linear system."""
    mine = imported("mine")
    api.register(mine.SLEDGE)
    scenario = api.load_scenario(
        "sledge.toml",
        {"plant.parameters.mass": 4.0, "load.constant": 0.5, "simulation.duration_s": 2.5},
    )
    found = api.evaluate(api.with_gains(scenario, "pd", {"kp": 10.0, "kd": 2.0}), scenario)
    state, errors = np.zeros(2), []
    for _ in range(250):
        error = 1.0 - state[0]
        force = 10.0 * error + 2.0 * (0.0 - state[1])
        errors.append(error)
        state = solve_ivp(
            lambda t, x, u: [x[1], (u - 3.0 * x[1] - 0.5) / 4.0],
            (0.0, 0.01),
            state,
            args=(force,),
            rtol=1e-10,
            atol=1e-12,
        ).y[:, -1]
    np.testing.assert_allclose(found.axes[0].motion.error, errors, atol=1e-9)


def test_an_own_law_runs_as_in_the_simulator(own):
    """The runtime steps the very law: command p times error."""
    mine = imported("mine")
    api.register(mine.P)
    scenario = api.load_scenario(scenario_of("only-p"))
    design = api.with_gains(scenario, "only-p", {"p": 3.0})
    assert api.Controller(design).step({"error": 0.5, "error_rate": 9.0}) == 1.5
    found = api.evaluate(design, scenario).axes[0].motion
    np.testing.assert_allclose(found.command, 3.0 * found.error, rtol=1e-12)
