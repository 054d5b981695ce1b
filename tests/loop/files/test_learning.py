"""What a motion has taught a controller: a design that starts the next one."""

from itertools import pairwise
from typing import Literal

import numpy as np
import pytest
from run_folders import ran
from wording import refused, refused_command

import hfc_design.api as hfc
from hfc_design.files.design import Design, learned
from hfc_design.formats import saving
from hfc_design.runtime import Controller, Machine

SHORT = {"simulation.duration_s": 2.5}
ROOT = {"controller.adaptation": {"largest_move": 0.8, "k_c": 0.1, "error_scale": 500.0}}


def stepped(design, evaluation):
    """A runtime that has seen what the axes told the control."""
    machine = Machine(design, evaluation.machine.axes)
    told = {axis.name: axis.sensed() for axis in evaluation.axes}
    for k in range(len(evaluation.time)):
        machine.step(
            {axis: {key: float(x[k]) for key, x in own.items()} for axis, own in told.items()}
        )
    return machine


class Level(hfc.ControllerRecord):
    """A gain, and a level that it learns."""

    kind: Literal["level"] = "level"
    gain: float
    level: float = 0.0

    def law_gains(self):
        return self.gain

    def law(self, limit):
        start = lambda law, zero: zero + law.structure  # noqa: E731
        return hfc.AxisLaw(levelling, start, 0.01, limit, self.level)

    def reads(self):
        return ["error"]

    def adapted(self, memory):
        return self.model_copy(update={"level": memory})


def levelling(xp, law, gains, memory, signals):
    level = memory + 0.5 * law.sample_time * signals["error"]
    return gains * signals["error"] + level, level, None


@pytest.fixture
def level(own_plugins):
    """A design of a kind that learns little."""
    hfc.register(Level)
    data = hfc.load_design("jee-koren-2004-pid").model_dump(mode="json")
    own = {"kind": "level", "sample_time_s": 0.01, "gain": 3.0}
    return Design.model_validate(data | {"name": "level", "controller": own})


def test_axes_that_have_learnt_other_things_have_controllers_of_their_own(level, tmp_path):
    """What the file holds is what the errors of the motion add up to."""
    scenario = hfc.load_scenario("feed-drive-circle", SHORT)
    evaluation = hfc.evaluate(level, scenario)
    found = hfc.learned_in(level, scenario, evaluation)
    assert found.name == "level-learned"
    told = {"from": "level", "scenario": "feed-drive-circle", "samples": 250}
    assert found.provenance["learned"] == told
    levels = {name: own.level for name, own in found.controller.axes.items()}
    for axis in evaluation.axes:
        assert levels[axis.name] == pytest.approx(0.005 * axis.sensed()["error"].sum(), rel=1e-9)
    assert levels["x"] != levels["y"]
    # It starts from there, and plain numbers learn the same.
    again = hfc.evaluate(found, scenario)
    twice = hfc.learned_in(found, scenario, again)
    assert twice.name == found.name
    expected = stepped(found, again).learned()
    for name, own in twice.controller.axes.items():
        assert own.level == pytest.approx(expected.controller.axes[name].level, rel=1e-9)
        assert own.level != levels[name]


def test_what_another_controller_has_learnt_is_refused(level):
    scenario = hfc.load_scenario("feed-drive-circle", SHORT)
    other = hfc.evaluate("jee-koren-2004-pid", scenario)
    with refused():
        hfc.learned_in(level, scenario, other)


def test_one_axis_has_one_controller(level):
    machine = Machine(level)
    machine.step({"axis": {"error": 2.0}})
    assert machine.learned().controller == level.controller.model_copy(update={"level": 0.01})


def test_what_cannot_be_kept_is_said():
    design = hfc.load_design("lin-lee-1999-table-1", ROOT)
    memory = Controller(design)._memory
    lost = memory._replace(root=memory.root._replace(moves=((np.nan,) * 7,) * 7))
    with refused():
        learned(design, ("axis",), (lost,), {})


def numbers(design):
    """What the code of a design would save that has learnt to command a tenth less."""
    table = design.controller.table()
    found = [0.9 * u for row in table.singletons for u in row]
    for terms in (table.error_terms, table.change_terms):
        found += [low[2] for low, _ in pairwise(terms)] + [high[0] for _, high in pairwise(terms)]
    return found


def test_numbers_of_an_axis_come_back_as_a_design(tmp_path):
    design = hfc.load_design("jee-koren-2004-aflc")
    learnt = numbers(design)
    assert len(learnt) == saving.saved(design).learnt
    one, other, hal = tmp_path / "x.json", tmp_path / "both.json", tmp_path / "kept.hal"
    (tmp_path / "x.txt").write_text("\n".join(map(repr, learnt)))
    like = ("--like", design.name)
    ran("import", tmp_path / "x.txt", *like, "--axis", "x", "--out", one)
    found = hfc.load_design(one).controller.axes
    assert found["y"] == design.controller
    table = np.array(design.controller.rules.centroids)
    assert np.array(found["x"].rules.centroids) == pytest.approx(0.9 * table)
    assert found["x"].error_terms == design.controller.error_terms
    lines = [f"setp y-controller.learnt-{k:02} {x:.7g}\n" for k, x in enumerate(learnt)]
    hal.write_text("setp x-controller.limit 0\n" + "".join(reversed(lines)))
    ran("import", hal, "--like", one, "--axis", "y", "--out", other)
    both = hfc.load_design(other)
    assert both.controller.axes["x"] == found["x"]
    assert np.array(both.controller.axes["y"].rules.centroids) == pytest.approx(0.9 * table)
    assert set(both.provenance["learned"]) == {"from", "source", "sha256"}


@pytest.mark.parametrize(
    ("text", "options", "where"),
    [
        ("1, 2; inf", (), "TEXT"),
        ("1", ("--axis", "z"), "--axis z"),
        ("1", ("--kind", "aflc"), "--kind"),
        ("1", ("--like", "pd-only"), "design pd-only is of kind pd"),
        (
            " ".join(["9"] * 73),
            (),
            "learned state of jee-koren-2004-aflc",
        ),  # no terms that could be
        ("1 1_0", (), "TEXT"),
        ("1 1e308", (), "TEXT"),
    ],
)
def test_numbers_that_are_no_state_of_the_design_are_refused(text, options, where, tmp_path):
    (tmp_path / "kept.txt").write_text(text)
    path = tmp_path / "out.json"
    like = () if "--like" in options else ("--like", "jee-koren-2004-aflc")
    line = refused_command("import", tmp_path / "kept.txt", *like, *options, "--out", path)
    assert line.where == (str(tmp_path / "kept.txt") if where == "TEXT" else where)
    assert line.count("\n") == 1
    assert not path.exists()


def test_inside_another_controller_it_learns_too(level):
    own = {"kind": "cross-coupled", "sample_time_s": 0.01, "contour": {"k_p": 1.0}}
    data = level.model_dump(mode="json") | {"name": "both"}
    both = Design.model_validate(data | {"controller": own | {"inner": data["controller"]}})
    scenario = hfc.load_scenario("feed-drive-circle", SHORT)
    evaluation = hfc.evaluate(both, scenario)
    inner = hfc.learned_in(both, scenario, evaluation).controller.inner
    for axis in evaluation.axes:
        wanted = 0.005 * axis.sensed()["error"].sum()
        assert inner.axes[axis.name].level == pytest.approx(wanted, rel=1e-9)
