"""Short runs on one scenario by each search strategy, and what they leave."""

import functools
import re

import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design

#: Gains of a PD controller: its programs are compiled soonest, and all searches share them.
#: Whether sticking is judged is a matter of form too.
SMALL = [
    *("simulation.duration_s=0.1", "search.population=12", "search.generations=5"),
    *("controller={kind='pd'}", "search.stick_penalty=0"),
]
TWO = "controller={inputs=[{name='error',scale=50.0},{name='deflection',scale=80.0}]}"
#: What each strategy changes in it; genes of structures need a hierarchy.
SEARCHES = {
    "race": [],
    "lin-lee": ["search.preset=lin-lee-1999", TWO],
    "cma": ["search.preset=cma"],
    "l-shade": ["search.preset=l-shade", "search.last=6"],
    "nsga-ii": ["search.preset=nsga-ii", "search.objectives=['tracking','effort']"],
}


def started(folder, changes=(), small=SMALL):
    return design.new_run(load_scenario("c-axis-ramp", [*small, *changes]), folder)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def stopping(scenario, folder, stop):
    """Run it up to a generation, as Ctrl-C ends it."""

    def interrupt(search):
        if search.generation == stop:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        design.run(scenario, folder, interrupt)
    assert not (folder / "design.json").exists()


def resumed(folder):
    return design.run(design.opened_run(folder), folder)


def once(path, small=SMALL):
    """A function that gives the folder and the result of an uninterrupted run, run once."""

    @functools.cache
    def whole(*changes):
        folder = path / re.sub(r"\W+", "-", " ".join(("whole", *changes)))
        return folder, design.run(started(folder, changes, small), folder)

    return whole
