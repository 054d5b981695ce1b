"""Search strategies of a user's own: one file, known by an option, a script or a package."""

import pytest
from own_strategies import MODULE
from sledge import imported
from wording import refused_command

from hfc_design import api

SMALL = ("--set", "simulation.duration_s=0.1", "--population", 12, "--generations", 5, "--quiet")
SIZES = {"simulation.duration_s": 0.1, "search.population": 12, "search.generations": 5}


@pytest.fixture
def searching(own):
    """The current folder, with a module of strategies that nobody has imported."""
    (own / "hunt.py").write_text(MODULE)
    return own


def test_random_search_is_what_it_says(searching):
    """The best of all that was drawn, and no generation like another."""
    api.register(imported("hunt").RANDOM)
    own = {"search.preset": "random", "controller": {"kind": "pd"}, **SIZES}
    scenario = api.load_scenario("c-axis-ramp", own)
    search = api.design(scenario).search
    assert search.state.draws == 60
    assert search.state.luck == search.history.best[-1] == search.state.seen.max()
    assert len(set(search.state.seen)) == 5


LACKING = "TAKEN NO_SETTINGS NO_STATE NO_MAKE Climb MUTE NOTHING FOREIGN BROKEN PICKY"


@pytest.mark.parametrize("reference", LACKING.split())
def test_a_strategy_that_lacks_something_is_told_so_in_a_line(reference, searching):
    options = ("--strategy", f"hunt:{reference}", "--preset", "climb", "--controller", "pd")
    found = refused_command("design", "c-axis-ramp", *options, "--out", "run", *SMALL)
    assert found.count("\n") == 1
