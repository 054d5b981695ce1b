"""Search strategies of a user's own: one file, known by an option, a script or a package."""

import pytest
from own_strategies import MODULE
from sledge import imported, refused

from hfc_design import api

SMALL = ("--set", "simulation.duration_s=0.1", "--population", 12, "--generations", 5, "--quiet")
SIZES = {"simulation.duration_s": 0.1, "search.population": 12, "search.generations": 5}
#: A hierarchy that is quickly compiled.
SCALES = {"error": 50.0, "deflection": 80.0}
TWO = [{"name": name, "scale": scale} for name, scale in SCALES.items()]


@pytest.fixture
def searching(own):
    """The current folder, with a module of strategies that nobody has imported."""
    (own / "hunt.py").write_text(MODULE)
    return own


def test_random_search_is_what_it_says(searching):
    """The best of all that was drawn, and no generation like another."""
    api.register(imported("hunt").RANDOM)
    own = {"search.preset": "random", "controller.inputs": TWO, **SIZES}
    scenario = api.load_scenario("c-axis-ramp", own)
    search = api.design(scenario).search
    assert search.state.draws == 60
    assert search.state.luck == search.history.best[-1] == search.state.seen.max()
    assert len(set(search.state.seen)) == 5


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
