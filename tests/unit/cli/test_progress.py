"""The lines of a search where there is no terminal."""

import re
from types import SimpleNamespace

import numpy as np

from hfc_design.cli.scoring import _refused
from hfc_design.cli.search_progress import Watch
from hfc_design.files.named_scenario import load_scenario


def searched(done):
    """A search after so many generations."""
    four = np.linspace(0.0, 1.0, done)
    history = dict.fromkeys(("best", "median", "diverged", "structures"), four)
    return SimpleNamespace(generation=done, history=SimpleNamespace(**history))


def test_no_line_says_that_nothing_is_left_when_much_is(monkeypatch, capsys):
    """Right after the compilation a generation seems to take no time."""
    now = [0.0]
    monkeypatch.setattr("hfc_design.cli.search_progress.time.monotonic", lambda: now[0])
    watch = Watch(load_scenario("c-axis-ramp", {"search.generations": 100}))
    for done, moment in ((1, 30.0), (2, 30.001), (3, 40.0), (4, 50.0), (5, 50.5), (50, 60.0)):
        now[0] = moment
        watch.generation(searched(done))
    lines = capsys.readouterr().err.splitlines()
    left = [re.search(r"(\d+) s left", line) for line in lines]
    assert [found and int(found[1]) for found in left] == [None, 485, 640, 31]


def test_machines_that_cannot_be_are_told_in_words():
    assert _refused(0) == ""
    assert _refused(12).startswith("12 draws were replaced, as their parameters are impossible")
