"""Search strategies of a user's own: one file, known by an option, a script or a package."""

import json

import numpy as np
import pytest
from batches import files
from own_strategies import MODULE
from sledge import hfc, imported, installed, refused

from hfc_design import api
from hfc_design.runs import individuals

SMALL = ("--set", "simulation.duration_s=0.1", "--population", 12, "--generations", 5, "--quiet")
SIZES = {"simulation.duration_s": 0.1, "search.population": 12, "search.generations": 5}
#: A hierarchy that is quickly compiled.
SCALES = {"error": 50.0, "deflection": 80.0}
TWO = [{"name": name, "scale": scale} for name, scale in SCALES.items()]
TWO_TOLD = ", ".join(f"{{name='{name}', scale={scale}}}" for name, scale in SCALES.items())


@pytest.fixture
def searching(own):
    """The current folder, with a module of strategies that nobody has imported."""
    (own / "hunt.py").write_text(MODULE)
    return own


@pytest.mark.slow
@pytest.mark.parametrize("name", ["random", "climb"])
@pytest.mark.parametrize("kind", ["pd", "pd+hierarchical-fuzzy"])
def test_on_the_command_line_with_every_kind(name, kind, searching, no_baselines):
    option = ("--strategy", f"hunt:{name.upper()}")
    small = SMALL if kind == "pd" else (*SMALL, "--set", f"controller.inputs=[{TWO_TOLD}]")
    done = hfc(
        "design",
        "c-axis-ramp",
        *option,
        "--preset",
        name,
        "--controller",
        kind,
        "--out",
        "run",
        *small,
    )
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


@pytest.mark.slow
def test_stopped_and_resumed_equals_uninterrupted(searching):
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


def test_random_search_is_what_it_says(searching):
    """The best of all that was drawn, and no generation like another."""
    api.register(imported("hunt").RANDOM)
    own = {"search.preset": "random", "controller.inputs": TWO, **SIZES}
    scenario = api.load_scenario("c-axis-ramp", own)
    search = api.design(scenario).search
    assert search.state.draws == 60
    assert search.state.luck == search.history.best[-1] == search.state.seen.max()
    assert len(set(search.state.seen)) == 5


def test_a_hierarchy_keeps_the_bounds_that_a_strategy_sets(searching):
    strategies = imported("hunt")

    class Narrow(strategies.ClimbSettings):
        kp_range: tuple[float, float] = (500.0, 501.0)
        scale_range: float = 1.0
        root_limit: float = 0.5

    api.register(strategies.CLIMB._replace(settings=Narrow))
    scenario = api.load_scenario("c-axis-ramp", {"search.preset": "climb", **SIZES})
    genome = individuals.genome_of(scenario)
    found = genome.fresh(np.arange(105), np.random.default_rng(0))
    assert 500.0 <= found.gains[:, 0].min() <= found.gains[:, 0].max() <= 501.0
    assert found.gains[:, 1].max() > 1000.0  # the default
    assert (found.scales == found.scales[0]).all()
    assert abs(found.consequents[:, -1]).max() == 0.5


def test_one_that_is_known_and_not_asked_for_is_refused(searching):
    for others in ((), ("--preset", "l-shade")):
        line = refused("design", "c-axis-ramp", "--strategy", "hunt:CLIMB", *others)
        assert line.endswith(f"would be {others[1] if others else 'race'}; add --preset climb\n")


def test_a_batch_of_strategies(searching):
    grid = '[grid]\nsearch.preset = ["random", "climb", "race"]\nrun.seed = [0, 1]\n'
    sizes = "[set]\nsearch.population = 6\nsearch.generations = 2\nsimulation.duration_s = 0.1\n"
    (searching / "batch.toml").write_text(f"{sizes}controller.kind = 'pd'\n{grid}")
    line = refused("batch", "batch.toml")
    for part in ("search.preset = 'random'", "no strategy known here", "--use module:OBJECT"):
        assert part in line
    options = ("--strategy", "hunt:RANDOM")
    assert "'climb'" in refused("batch", "batch.toml", *options)
    api.register(imported("hunt").CLIMB)
    done = hfc("batch", "batch.toml", *options, "--out", "out")
    assert done.exit_code == 0, done.output
    assert len([name for name in files(searching / "out") if name.endswith("design.json")]) == 6


def test_a_package_brings_a_strategy(searching):
    installed(searching, "[hfc_design.strategies]", "climb = hunt:CLIMB")
    scenario = api.load_scenario("c-axis-ramp", {"search.preset": "climb", **SIZES})
    assert scenario.search.step == 0.3
    assert "a hill climber" in hfc("list", "strategies").stdout


def test_names_of_strategies(searching):
    assert list(api.strategies) == ["cma", "l-shade", "lin-lee-1999", "nsga-ii", "race"]
    climb = api.register(imported("hunt").CLIMB)
    assert api.strategies["climb"] is climb
    assert api.load_scenario("c-axis-ramp").search.preset == "race"


@pytest.mark.parametrize(
    ("reference", "words"),
    [
        ("TAKEN", ["'race' is built in", "another name"]),
        ("NO_SETTINGS", ["strategy 'climb'", "settings", "StrategySettings"]),
        ("NO_STATE", ["strategy 'climb'", "state", "NamedTuple"]),
        ("NO_MAKE", ["strategy 'climb'", "make = None: has to be a function"]),
        ("Climb", ["is a type and no Strategy"]),
        ("MUTE", ["strategy 'climb' cannot search: make", "no attribute 'tell'"]),
        ("NOTHING", ["strategy 'climb' cannot search", "start", "no attribute 'population'"]),
        ("FOREIGN", ["strategy 'climb' cannot search", "tell gave no Best"]),
        ("BROKEN", ["strategy 'climb' cannot search", "ZeroDivisionError"]),
        ("PICKY", ["search.preset = 'climb'", "searches no pd"]),
    ],
)
def test_a_strategy_that_lacks_something_is_told_so_in_a_line(reference, words, searching):
    options = ("--strategy", f"hunt:{reference}", "--preset", "climb", "--controller", "pd")
    line = refused("design", "c-axis-ramp", *options, "--out", "run", *SMALL)
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"search.preset": "swarm"}, ["search.preset = 'swarm'", " race,", "hfc.register"]),
        ({"search.preset": 3}, ["search.preset = 3"]),
        ({"search.preset": "climb", "search.step": "far"}, ["search.step = 'far'"]),
        ({"search.preset": "climb", "search.tournament": 3}, ["search.tournament = 3"]),
        ({"search.preset": "climb", "search.population": 0}, ["search.population = 0"]),
        ({"search.kp_range": [5.0, 1.0]}, ["search.kp_range", "[low, high]"]),
        ({"search": 5}, ["search = 5"]),
    ],
)
def test_searches_that_cannot_be(change, words, searching):
    api.register(imported("hunt").CLIMB)
    with pytest.raises(api.UserError) as error:
        api.load_scenario("c-axis-ramp", change)
    for word in words:
        assert word in str(error.value)
