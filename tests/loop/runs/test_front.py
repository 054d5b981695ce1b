"""The front of a run: its file, the designs of its points."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from run_folders import hfc, table
from shaken import shaken
from short_runs import SEARCHES, SMALL, once
from wording import refused_command

from hfc_design.controllers.genome import taken
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import RunError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.trade_off import front_table
from hfc_design.runs import champion
from hfc_design.runs import front as fronts
from hfc_design.runs import run as design
from hfc_design.runs.individuals import design_of, genome_of
from hfc_design.search.loop import Archive
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.repeats import Repeats


@pytest.fixture(scope="module")
def wholes(tmp_path_factory):
    return once(tmp_path_factory.mktemp("fronts"))


@pytest.fixture
def folder(wholes):
    return wholes(*SEARCHES["nsga-ii"])[0]


def test_the_marked_points_can_be_picked(folder, tmp_path):
    rows = table(folder / "front.csv")
    best = next(k for k, row in enumerate(rows, 1) if "design" in row["mark"])
    hfc("pick", folder, "--point", best, "--out", tmp_path / "best.json")
    own, design_of_run = (
        json.loads(path.read_text()) for path in (tmp_path / "best.json", folder / "design.json")
    )
    assert own == design_of_run
    hfc("pick", folder, "--knee", "--out", tmp_path / "knee.json")
    knee = next(k for k, row in enumerate(rows, 1) if "knee" in row["mark"])
    hfc("pick", folder, "--point", knee, "--out", tmp_path / "same.json")
    assert (tmp_path / "knee.json").read_bytes() == (tmp_path / "same.json").read_bytes()


def test_nearest_is_in_shares_of_the_front(folder):
    scenario, result = design.finished_run(folder)
    front = result.front
    effort = float(front.costs[3, 1])
    assert fronts.chosen(front, scenario, None, {"effort": effort}) == 3
    told = {"effort": f"{effort:.12f} V", "tracking": f"{1e6 * front.costs[3, 0]:.9f} urad"}
    assert fronts.chosen(front, scenario, None, told) == 3
    assert fronts.chosen(front, scenario, None, {"tracking": -1.0}) == 0


def test_the_table_has_the_ends_and_the_marked_points(folder):
    _, result = design.finished_run(folder)
    _, head, rows, *_ = front_table(result.front, 5)
    numbers = [int(row[0]) - 1 for row in rows]
    assert {0, result.front.knee, result.front.best, len(result.front.merit) - 1} <= {*numbers}
    assert head[0] == "point"
    assert head[1].startswith("tracking [")
    assert len(rows) <= 5


@pytest.mark.parametrize(
    "options",
    [
        ["--nearest", "chatter=2"],
        ["--nearest", "effort='2 rad'"],
        ["--nearest", "effort"],
        ["--knee", "--point", 1],
        [],
    ],
)
def test_what_cannot_be_picked_is_told_in_a_line(options, folder, tmp_path):
    refused_command("pick", folder, *options, "--out", tmp_path / "x.json")
    assert not (tmp_path / "x.json").exists()


def test_a_pick_needs_a_file_and_a_front(folder, wholes, tmp_path):
    refused_command("pick", folder, "--knee")
    last = len(table(folder / "front.csv"))
    done = hfc("pick", folder, "--point", 0, "--out", tmp_path / "x.json")
    assert (done.exit_code, done.stderr) == (2, f"hfc: --point 0: must be 1 to {last}\n")
    other, _ = wholes()
    found = refused_command("pick", other, "--knee", "--out", tmp_path / "x.json")
    assert found.where == str(other)


def test_a_damaged_file_is_told(folder):
    kept = (folder / "front.csv").read_bytes()
    other = kept.replace(b"tracking", b"speed")
    for wrong in (
        b"",
        other,
        kept + b"9,nan,1,1,,0\n",
        kept[:-1] + b"99\n",
    ):
        write_whole(folder / "front.csv", wrong)
        with pytest.raises(RunError, match=r"front.csv: is missing or damaged"):
            design.finished_run(folder)
    write_whole(folder / "front.csv", kept)
    design.finished_run(folder)


#: Merits of the repeats, the loop as it is first; what the search found is in this order.
LUCKY, STEADY = [430.8, 511.0, 362.0], [380.0, 380.1, 379.9]


@pytest.mark.parametrize(
    ("each", "chosen"),
    [
        ([LUCKY, STEADY], 1),
        ([STEADY, LUCKY], 0),
        ([LUCKY, [350.0, 350.0, 350.0]], 0),  # the worst of it is better still
        ([[430.8, -np.inf, 440.0], STEADY], 1),
        ([[380.0, 379.0, 380.0], [380.1, 376.4, 380.2]], 1),  # by the merit: none is chaotic
    ],
)
def test_finalists_rank_by_their_lower_end(each, chosen, monkeypatch):
    scenario = load_scenario("c-axis-ramp", SMALL)
    found = genome_of(scenario).fresh(np.zeros(2, int), np.random.default_rng(0))
    designs = [design_of(taken(found, np.array([k])), scenario) for k in range(2)]

    def judged(design, where):
        (own,) = (x for x, one in zip(each, designs, strict=True) if one == design)
        repeats = {"merit": Repeats(np.array(own))}
        return evaluate(design, where)._replace(merit=own[0], repeats=repeats)

    monkeypatch.setattr(champion, "evaluate", judged)
    searched = SimpleNamespace(archive=Archive(found, np.array([2.0, 1.0])), state=None)
    _, design, evaluation = next(champion.best_of(searched, scenario))
    assert design.controller == designs[chosen].controller
    assert evaluation.merit == each[chosen][0]
    assert design.score.get("chaotic", False) == evaluation.chaotic


def test_of_two_points_that_are_as_near_the_first_is_taken():
    """1.5 mrad is halfway between 1 and 2, but for its last bits."""
    scenario = load_scenario("c-axis-ramp", SEARCHES["nsga-ii"])
    for costs in shaken(1e-3, 2e-3, 3e-3, 1.5e-3):
        points = np.column_stack([costs[:3], [3.0, 2.0, 1.0]])
        front = fronts.Front(scenario.traded, points, np.ones(3), np.arange(3))
        assert fronts.chosen(front, scenario, None, {"tracking": costs[3]}) == 0
