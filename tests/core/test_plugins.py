"""Own plants, fitnesses and control laws: how they come in, and what they compute."""

import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from imported_files import GAUSSIAN
from scipy.integrate import solve_ivp
from sledge import BUDGET, SCENARIO, api_text, hfc, imported, installed, refused, scenario_of

from hfc_design import api
from hfc_design.controllers.kinds import KINDS
from hfc_design.files.design import design_json
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish
from hfc_design.formats.reading import imported as imported_design


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


def test_a_batch_knows_an_own_plant(own):
    grid = "[grid]\nscenario = ['sledge.toml']\nrun.seed = [0, 1]\n"
    sizes = "[set]\nsearch.population = 4\nsearch.generations = 1\n"
    (own / "batch.toml").write_text(sizes + grid)
    assert "'sledge'" in refused("batch", "batch.toml")
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
    assert "--use module:OBJECT" in refused("stability", file)
    line = refused("stability", file, "--plant", "mine:SLEDGE")
    for part in ("sledge", "no feed drive", "--gain", "--time-constant"):
        assert part in line
    assert "--gain" in refused("stability", file, "--plant", "mine:SLEDGE", "--gain", "28.3")
    drive = ("--gain", "28.3", "--time-constant", "0.055")  # those of the published design
    done = hfc("stability", file, "--plant", "mine:SLEDGE", *drive, "--json")
    assert done.stdout == hfc("stability", "jee-koren-2004-flc", "--json").stdout
    # A plant of one's own with the parameters of the feed drive is one.
    (own / "smooth.py").write_text(
        "from dataclasses import replace\nfrom plants import FEED_DRIVE\n"
        "PLANT = replace(FEED_DRIVE, name='sledge')\n"
    )
    assert hfc("stability", file, "--plant", "smooth:PLANT", "--json").stdout == done.stdout
    file = design_for_the_sledge("pd-only")
    assert "no flc, aflc or soflc" in refused("stability", file, "--plant", "mine:SLEDGE")


def test_a_controller_is_imported_for_an_own_plant(own):
    """The loop's first command is the runtime's, of the same file for the C-axis."""
    signals = ("--signal", "deflection=speed")
    command = ("import", GAUSSIAN, "--plant", "mine:SLEDGE", "--out", "mine.json", *signals)
    assert "--sample-time" in refused(*command)
    done = hfc(*command, "--sample-time", "0.01")
    assert done.exit_code == 0, done.output
    design = json.loads(Path("mine.json").read_text())
    assert design["plant"]["name"] == "sledge"
    assert [item["name"] for item in design["controller"]["inputs"]] == ["speed", "error"]
    done = hfc(
        "simulate", "mine.json", "--scenario", "sledge.toml", "--set", "reference.height=0.3"
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
    assert "'deflection'" in refused(*command[:6], "--force", "--sample-time", "0.01")
    assert "'rocket'" in refused("import", GAUSSIAN, "--plant", "rocket")


def test_the_loop_of_an_own_plant_is_that_of_scipy(own):
    """A PD law held over each sample is a piecewise linear system."""
    mine = imported("mine")
    api.register(mine.SLEDGE)
    scenario = api.load_scenario(
        "sledge.toml", {"plant.parameters.mass": 4.0, "load.constant": 0.5}
    )
    found = api.evaluate(api.with_gains(scenario, "pd", {"kp": 10.0, "kd": 2.0}), scenario)
    state, errors = np.zeros(2), []
    for _ in range(300):
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


def test_own_fitness_and_controller_by_reference(own):
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


def test_an_own_law_runs_as_in_the_simulator(own):
    """The runtime steps the very law: command p times error."""
    mine = imported("mine")
    api.register(mine.P)
    scenario = api.load_scenario(scenario_of("only-p"))
    design = api.with_gains(scenario, "only-p", {"p": 3.0})
    assert api.Controller(design).step({"error": 0.5, "error_rate": 9.0}) == 1.5
    found = api.evaluate(design, scenario).axes[0].motion
    np.testing.assert_allclose(found.command, 3.0 * found.error, rtol=1e-12)


@pytest.mark.parametrize("target", FORMATS)
def test_formats_take_an_own_kind_or_refuse_it_in_a_line(own, target):
    api.register(imported("mine").P)
    design = api.with_gains(api.load_scenario(scenario_of("only-p")), "only-p", {"p": 3.0})
    if target in ("json", "mat", "fmu-plant"):  # the last holds nothing of a controller
        assert api.export(design, target, "out").stat().st_size > 0
    else:
        with pytest.raises(api.UserError, match="kind only-p"):
            api.export(design, target, "out")
        assert not (own / "out").exists()


@cache
def searched():
    """The file of a hierarchy for the sledge, which has to be known."""
    scenario = api.load_scenario(
        "sledge.toml",
        {
            "controller": {"inputs": [{"name": n, "scale": 1.0} for n in ("error", "speed")]},
            "search": {"population": 2, "generations": 1, "newton_islands": 0},
        },
    )
    return design_json(api.design(scenario).design)


#: Formats with a machine in C, which an own one has not.
SIMULATED = ("fmu-loop", "fmu-plant", "linuxcnc")


@pytest.mark.parametrize("target", [name for name in FORMATS if name not in SIMULATED])
def test_formats_take_an_own_plant(own, target):
    api.register(imported("mine").SLEDGE)
    (own / "found.json").write_text(searched())
    assert api.export(api.load_design("found.json"), target, "out").exists()


def test_entry_points(own, tmp_path):
    installed(
        tmp_path,
        "[hfc_design.plants]",
        "sledge = mine:SLEDGE",
        "rocket = mine:ROCKET",
        "other = mine:SLEDGE",
        "[hfc_design.fitness]",
        "last-error = mine:LAST",
        "[hfc_design.controllers]",
        "only-p = mine:P",
    )
    text = SCENARIO + "[fitness]\nkind = 'last-error'\n[controller]\nkind = 'only-p'\n"
    (tmp_path / "sledge.toml").write_text(text)
    scenario = api.load_scenario("sledge.toml")
    assert scenario.plant.machine.name == "sledge"
    assert scenario.judge().objectives[0].name == "last-error"
    assert scenario.controller.kind == KINDS.get("only-p").name == "only-p"
    assert "entry point rocket = mine:ROCKET: mine has no ROCKET" in refused(
        "design", "sledge.toml", "--plant", "rocket"
    )
    assert "its name is 'sledge'" in refused("design", "sledge.toml", "--plant", "other")


def test_lists_show_what_packages_bring(own, tmp_path):
    installed(tmp_path, "[hfc_design.plants]", "sledge = mine:SLEDGE")
    done = hfc("list", "plants")
    assert done.exit_code == 0, done.output
    assert "sledge" in done.stdout
    assert re.search(r"\nmass +[\d.]+.*\nfriction +[\d.]+", done.stdout)


def test_a_built_in_plant_cannot_be_replaced(own, tmp_path):
    installed(tmp_path, "[hfc_design.plants]", "c-axis = mine:SLEDGE")
    built_in = ALL_PLANTS.get("c-axis")
    (drive,) = api.load_scenario("c-axis-ramp").plant.machine.drives
    assert drive is built_in
    with pytest.raises(api.UserError, match="built in"):
        api.register(imported("mine").TAKEN)


def test_an_own_one_can_be_registered_again(own):
    """A cell of a notebook runs twice, with another object under the same name."""
    mine = imported("mine")
    api.register(mine.SLEDGE)
    heavier = api.register(mine.sledge())
    assert ALL_PLANTS.get("sledge") is heavier


def test_two_packages_with_one_name_are_refused(own, tmp_path):
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        installed(folder, "[hfc_design.plants]", "sledge = mine:SLEDGE")
        place = folder / "sledges-1.0.dist-info"
        place.rename(folder / f"{name}-1.0.dist-info")
        metadata = folder / f"{name}-1.0.dist-info" / "METADATA"
        metadata.write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    with pytest.raises(api.UserError, match="several packages"):
        ALL_PLANTS.get("sledge")
