"""Search strategies of a user's own: one file, known by an option, a script or a package."""

import json

import pytest
from batches import files
from own_strategies import SIZES
from sledge import hfc, imported, refused

from hfc_design import api

SMALL = ("--set", "simulation.duration_s=0.1", "--population", 12, "--generations", 5, "--quiet")
#: A hierarchy that is quickly compiled.
SCALES = {"error": 50.0, "deflection": 80.0}
TWO = [{"name": name, "scale": scale} for name, scale in SCALES.items()]
TWO_TOLD = ", ".join(f"{{name='{name}', scale={scale}}}" for name, scale in SCALES.items())


@pytest.mark.parametrize(("name", "kind"), [("random", "pd"), ("climb", "pd+hierarchical-fuzzy")])
def test_on_the_command_line_with_every_kind(name, kind, searching, no_baselines, known_use):
    option = ("--strategy", f"hunt:{name.upper()}")
    small = SMALL if kind == "pd" else (*SMALL, "--set", f"controller.inputs=[{TWO_TOLD}]")
    asked = ("--preset", name, "--controller", kind, "--out", "run", *small)
    done = hfc("design", "c-axis-ramp", *option, *asked)
    assert done.exit_code == 0, done.output
    design = json.loads((searching / "run" / "design.json").read_text())
    assert design["controller"]["kind"] == kind
    assert f'preset = "{name}"' in (searching / "run" / "config.toml").read_text()
    penalty = " / (1 + 5 stick share)" if name == "climb" else ""
    assert design["score"]["judged_by"] == f"fitness, LL eq. 5{penalty}"
    assert design["provenance"]["plugins"]["strategy"] == {name: f"hunt:{name.upper()}"}
    assert "run/report.html" in hfc("report", "run", *option).stdout
    again = json.loads(hfc("score", "run", "--json", *option).stdout)
    assert again["merit"] == design["score"]["merit"]


@pytest.mark.usefixtures("no_baselines")
def test_stopped_and_resumed_equals_uninterrupted(searching, known_use):
    strategies = imported("hunt")
    for strategy in (strategies.RANDOM, strategies.CLIMB):
        api.register(strategy)
        own = {"search.preset": strategy.name, "controller.inputs": TWO, **SIZES}
        scenario = api.load_scenario("c-axis-ramp", own)
        whole = api.design(scenario, f"whole-{strategy.name}")

        class Stopped(Exception):
            pass

        def stop(search):
            if search.generation == 2:
                raise Stopped

        parts = searching / f"parts-{strategy.name}"
        with pytest.raises(Stopped):
            api.design(scenario, parts, stop)
        resumed = api.design(scenario, parts)
        assert type(resumed.search.state) is strategy.state
        for one, other in zip(whole.search.state, resumed.search.state, strict=True):
            assert type(one) is type(other)
        for file in ("design.json", "history.csv", "checkpoint.npz", "report.html"):
            assert (parts / file).read_bytes() == (
                searching / f"whole-{strategy.name}" / file
            ).read_bytes()


def test_a_batch_of_strategies(searching):
    grid = '[grid]\nsearch.preset = ["random", "climb", "race"]\nrun.seed = [0, 1]\n'
    sizes = "[set]\nsearch.population = 6\nsearch.generations = 2\nsimulation.duration_s = 0.1\n"
    (searching / "batch.toml").write_text(f"{sizes}controller.kind = 'pd'\n{grid}")
    line = refused("batch", "batch.toml")
    for part in ("search.preset = 'random'", "unknown strategy", "--use module:OBJECT"):
        assert part in line
    options = ("--strategy", "hunt:RANDOM")
    assert "'climb'" in refused("batch", "batch.toml", *options)
    api.register(imported("hunt").CLIMB)
    done = hfc("batch", "batch.toml", *options, "--out", "out")
    assert done.exit_code == 0, done.output
    assert len([name for name in files(searching / "out") if name.endswith("design.json")]) == 6
