"""What would give a yes: made-up machines, with answers that are counted by hand."""

import re

import numpy as np
import pytest

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.robust import RobustSettings
from hfc_design.objectives.judge import Judged
from hfc_design.simulation import why_not
from hfc_design.simulation.acceptance import Stressed
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import Machines
from hfc_design.simulation.stress import cases
from hfc_design.simulation.usable_tables import MENDS, stress_table, why_table
from hfc_design.simulation.why_not import deviations, least, widest

COUNT = 220
SCENARIO = load_scenario(
    {
        "name": "made-up",
        "motions": [{"name": "a"}, {"name": "b", "reference": {"kind": "ramp", "velocity": 0.02}}],
        "constraints": {"chatter": "4000 mV", "late_error": 0.01},
    }
)
ROBUST = RobustSettings(spread=0.22, unseen=COUNT)
#: Machine k has 0.1 k % more inertia of its rotor, and nothing else of its own.
(NOMINAL,) = SCENARIO.plant.values()
MORE = 0.001 * np.arange(COUNT + 1)


def machines():
    leaves = {name: np.full(COUNT + 1, x) for name, x in NOMINAL._asdict().items()}
    leaves["rotor_inertia"] = NOMINAL.rotor_inertia * (1.0 + MORE)
    return Machines((NOMINAL,), (type(NOMINAL)(**leaves),))


def judged(**changes):
    """(machines, 2 motions), all well but for what is told of motion b: measure -> (machines,)."""
    names = ("rms", "chatter", "peak", "unsettled", "limit_share", "late_error")
    values = np.zeros((COUNT + 1, 2, len(names)))
    for name, column in changes.items():
        values[:, 1, names.index(name)] = column
    return Judged(np.ones((COUNT + 1, 2)), values, np.zeros((COUNT + 1, 2), bool))


def told(found, again=lambda _: judged(), short=(), scenario=SCENARIO):
    return why_not.why_not(scenario, ROBUST, machines(), found, again, dict(short))


@pytest.fixture(autouse=True)
def no_needs(monkeypatch):
    """No drive is linearised."""
    monkeypatch.setattr(why_not, "needed", lambda *_: ((1.0, 300.0), (1.0, np.inf)))


def test_every_change_by_hand():
    """Ten of 220 have too much chatter, in b; two may fail, so the eighth has to pass."""
    loud = np.append(np.zeros(211), 4.1 + 0.1 * np.arange(10))

    def again(nearer):
        off = nearer.actual[0].rotor_inertia / NOMINAL.rotor_inertia - 1.0
        return judged(chatter=np.where(off > 0.0901, 5.0, 0.0))

    found = told(judged(chatter=loud), again)
    each = {one["key"]: one for one in found["changes"]}
    assert {key: (one["now"], one["needed"], one["lost"]) for key, one in each.items()} == {
        # 4.8 V, in the unit of the file and rounded up.
        "constraints.chatter": ("4000 mV", "4824 mV", 10),
        "motions.b.machines": ("all", "nominal", 10),
        # Two of 212 are less than 1 %, three of 213 more; 0.212, rounded down.
        "robust.tolerances.rotor_inertia": ("0.22", "0.211 (212)", None),
        # At 3/8 the most is 8.25 %, at 4/8 40 machines have 9 to 11 %.
        "robust.spread": ("0.22", "0.0825", 10),
    }
    assert each["constraints.chatter"]["without"] == each["motions.b.machines"]["without"] == 1.0
    assert each["robust.spread"]["without"] == pytest.approx(180 / 220)
    assert [one["key"] for one in found["changes"]][-1] == "robust.spread"
    assert found["lines"] == []
    assert why_table(found).rows[-1] == ["robust.spread", "0.22", "0.0825", "10", "81.8"]


def test_what_fails_is_told_with_what_it_has_in_common_and_what_the_drive_would_need(monkeypatch):
    """Machines 201 to 220 oscillate in b, all in a: of these the median has 21 % more inertia."""
    swings, inertia = np.where(MORE > 0.2005, 1.0, 0.0), NOMINAL.rotor_inertia
    found = judged(unsettled=swings)
    found.values[1:4, 0, 3] = 1.0

    def needed(drive, own, *_):
        return (250.0 + 60.0 * (own.rotor_inertia > 1.2185 * inertia), 300.0), (1.0, np.inf)

    def again(nearer):
        """All of them well but in b, where they are as before."""
        return judged(unsettled=swings)

    monkeypatch.setattr(why_not, "needed", needed)
    lines = told(found, again)["lines"]
    assert lines == [
        "none of the single changes tried gives a yes",
        "both changes together: motions.b.machines nominal, robust.spread 0.1925",
        "20 oscillate in b, mostly with high rotor_inertia (+21 %)",
        "3 oscillate in a",
        "a needs 250 of 300 V on the nominal machine, 250 of 300 on the worst of 3 that fail",
        "b needs 250 of 300 V on the nominal machine, 310 of 300 on the worst of 20 that fail: "
        "beyond the limit on 2 of them",
    ]
    monkeypatch.setattr(why_not, "needed", lambda *_: ((30.0, 300.0), (1.0, np.inf)))
    held = told(judged(limit_share=swings))
    assert held["lines"][-1] == "at a limit, although at most 10 % of it is needed: b"


def test_no_tolerance_helps_a_nominal_machine_that_fails():
    """Its own value is the least limit; of a loop that is unstable nothing is."""
    loud = np.append(6.0, np.zeros(COUNT))
    (one,) = told(judged(chatter=loud))["changes"]
    assert (one["key"], one["needed"], one["lost"]) == ("constraints.chatter", "6030 mV", 0)
    found = told(
        judged(chatter=np.append(0.0, np.full(COUNT, 5.0))), short={"stable": (None, "unstable")}
    )
    assert {one["needed"] for one in found["changes"]} == {None}
    assert found["lines"][0] == "none of the single changes tried gives a yes"


@pytest.mark.parametrize(
    ("name", "value", "needed"),
    [("sensitivity", 2.013, "2.02"), ("delay_margin_samples", 0.4, "0.398")],
)
def test_a_margin_alone_that_is_not_kept_is_what_gives_a_yes_and_nothing_else_does(
    name, value, needed
):
    """Ten of 220 machines have too much chatter, or none has."""
    asked = SCENARIO.model_copy(update={"constraints": SCENARIO.constraints | {name: 2.0}})
    short = {name: (value, "in words")}
    (one,) = (x for x in told(judged(), short=short, scenario=asked)["changes"] if x["needed"])
    assert (one["key"], one["now"], one["needed"]) == (f"constraints.{name}", "2.0", needed)
    assert one["without"] == 1.0
    loud = judged(chatter=np.append(np.zeros(211), np.full(10, 5.0)))
    both = short | {"gain_margin": (1.1, "in words")}
    for found in (told(loud, short=short, scenario=asked), told(judged(), short=both)):
        assert not any(x["needed"] for x in found["changes"])
        assert found["lines"][0] == "none of the single changes tried gives a yes"


def test_what_is_far_off_is_within_a_looser_late_error_whether_there_was_one_or_not():
    late = np.append(0.0, 0.0001 * np.arange(1, COUNT + 1))  # the 218th has 21.8 mrad
    found = judged(late_error=late)
    now = told(found)["changes"]
    free = SCENARIO.model_copy(update={"constraints": {"chatter": "4000 mV"}})
    before = told(found, scenario=free)["changes"]
    for changes, told_now in ((now, "0.01 rad"), (before, "-")):
        one = {one["key"]: one for one in changes}.get("constraints.late_error")
        assert one is not None
        assert one["now"] == told_now
        size, unit = one["needed"].split()
        assert 0.0218 <= float(size) < 0.0220
        assert unit == "rad"
    far = told(judged(late_error=10.0 * late))["changes"]  # beyond the motion itself
    assert not any(one["needed"] for one in far if one["key"] == "constraints.late_error")


def test_limits_and_distances_need_enough_machines():
    values = np.arange(101.0)
    assert least(values, np.zeros(101, bool)) == 99.0
    assert least(np.append(99.5, values[1:]), np.zeros(101, bool)) == 99.5
    assert least(values, np.append(np.zeros(99, bool), [True, True])) is None
    assert widest(np.arange(99.0), np.zeros(99, bool)) is None
    assert widest(np.arange(100.0), np.zeros(100, bool)) == (99.0, 100)


def test_every_stress_has_its_own_mend():
    """What happens then and where says nothing of it, as of a motion that is called rest."""
    own = load_scenario("c-axis-practical", {"stress.modes": [{"hz": 60.0}]})
    one = Stressed("", False, 0.5, 0.0, why="oscillates in a rest with noise")
    found = {}
    for case in cases(own, 20.0):
        name = case.description(1.0)
        found[name] = stress_table([one._replace(breaks=name).numbers()]).lines[-1]
    for words, mend in MENDS.items():
        told = [name for name, line in found.items() if f"first step: {mend};" in line]
        assert told, words
        assert all(re.search(words, name) for name in told)
    assert [name for name in found if MENDS[""] in found[name] and "load" in name]


def test_a_machine_is_as_far_off_as_the_axis_that_is_most():
    plant = load_scenario("milling-table-circle").plant
    some, _ = drawn(plant, 0.1, 3, 1, {"load": 5.0})
    found = deviations(some)
    masses = np.array([own.table_mass[1:] / own.table_mass[0] - 1.0 for own in some.actual])
    assert np.abs(found["table_mass"]).tolist() == np.abs(masses).max(axis=0).tolist()
    assert np.abs(found["load"]).tolist() == np.abs(some.around["load"][:, 1:]).max(axis=0).tolist()
    half = deviations(why_not.nearer(some, 0.5))
    assert half["load"] == pytest.approx(0.5 * found["load"])
    assert half["table_mass"] == pytest.approx(0.5 * found["table_mass"])
