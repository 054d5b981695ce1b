"""What a connected controller does when it is switched, by hand (docs/machine-builder.md)."""

from itertools import pairwise
from math import exp

import pytest
import whole_machines
from connections import simulated

import hfc_design.api as hfc
from hfc_design import runtime
from hfc_design.controllers.connected import Begins, Connection, Sensing, connected
from hfc_design.controllers.controller import AxisLaw, PathView
from hfc_design.core.numbers import SCALARS
from hfc_design.formats import saving
from hfc_design.formats.connection import connect
from hfc_design.formats.laws import recorded_law

K_P, K_I, EVERY = 1.5, 8.1, 0.01  # of jee-koren-2004-pid


class Stepped:
    """The connected PID of a feed drive, whose scale reads whole BLU, sample by sample."""

    def __init__(self):
        design = connect(hfc.load_design("jee-koren-2004-pid"))
        self.gains = design.controller.law_gains()
        self.law = design.connected.around(design.kind.law(design.controller, None))
        self.memory = self.law.begun(SCALARS, 0.0, self.gains)
        self.fresh = True

    def step(self, error, **told):
        signals = {"enable": 1.0, "reference": 100.0, "position": 100.0 - error, **told}
        if self.fresh:
            self.memory = self.law.primed(SCALARS, self.gains, self.memory, signals)
        self.fresh = False
        command, self.memory, _ = self.law.sample(
            SCALARS, self.law, self.gains, self.memory, signals
        )
        return command


def commands(design, rows):
    """What the law of a connected design commands in samples of its inputs."""
    gains = design.controller.law_gains()
    law = design.connected.around(design.kind.law(design.controller, None))
    memory, found = law.begun(SCALARS, 0.0, gains), []
    for row in rows:
        signals = dict(zip(design.connected.units, row, strict=True))
        if not found:
            memory = law.primed(SCALARS, gains, memory, signals)
        command, memory, _ = law.sample(SCALARS, law, gains, memory, signals)
        found.append(command)
    return found


@pytest.mark.parametrize("name", ["pd-only on a turn", "pd-only on a turn in differences"])
def test_reading_and_reference_may_begin_anew_after_a_turn(name):
    design, rows, _ = simulated(name)
    places = [list(design.connected.units).index(x) for x in ("reference", "spindle_angle")]
    again = [[x % 0.004 if k in places else x for k, x in enumerate(row)] for row in rows]
    assert sum(abs(a[places[1]] - b[places[1]]) > 0.002 for a, b in pairwise(again)) > 10
    exact = commands(design, rows)
    assert commands(design, again) == pytest.approx(exact, abs=1e-8 * max(map(abs, exact)))


FIRST = K_P * 2.0 + K_I * EVERY * 2.0  # with a standing error of 2 BLU


def test_while_it_is_off_nothing_winds_up():
    one = Stepped()
    one.step(2.0)
    assert [one.step(50.0, enable=0.0) for _ in range(1000)] == [0.0] * 1000
    assert one.step(2.0) == pytest.approx(FIRST)


def test_a_preset_is_added():
    one = Stepped()
    assert one.step(2.0, preset=5.0) == pytest.approx(FIRST + 5.0)
    assert one.step(2.0, preset=7.0) == pytest.approx(FIRST + K_I * EVERY * 2.0 + 7.0)


def test_it_takes_over_without_a_jump():
    """From the command of another controller it goes to its own."""
    one, same = Stepped(), Stepped()
    one.step(2.0, enable=0.0)
    assert one.step(2.0, preset=40.0, take_over=1.0) == pytest.approx(40.0)
    same.step(2.0)
    for k in range(1, 100):
        own = same.step(2.0)
        left = (40.0 - FIRST) * exp(-k / 50.0)
        assert one.step(2.0, preset=40.0, take_over=1.0) == pytest.approx(own + left)


def test_an_error_that_is_too_large_stops_it_until_it_is_switched_off():
    one = Stepped()
    assert one.step(9.0, largest_error=10.0) != 0.0
    assert one.step(11.0, largest_error=10.0) == 0.0
    assert one.memory.tripped == 1.0
    assert one.step(0.0, largest_error=10.0) == 0.0
    one.step(0.0, enable=0.0)
    assert one.step(2.0, largest_error=10.0) == pytest.approx(FIRST)
    assert one.memory.tripped == 0.0


def test_a_command_whose_rate_is_limited_begins_at_0():
    design = hfc.load_design("jee-koren-2004-pid", {"limits": {"command_rate": 100.0}})
    one = Stepped()
    found = connect(design)
    one.law = found.connected.around(design.kind.law(design.controller, None))
    commanded = [one.step(50.0) for _ in range(3)]
    assert commanded == pytest.approx([1.0, 2.0, 3.0])
    one.step(50.0, enable=0.0)
    assert one.step(50.0) == pytest.approx(1.0)


class Machine:
    """A connected controller of two feed drives, a PID on each and one on the contour error."""

    def __init__(self):
        self.own = connect(whole_machines.DESIGNS["pid"])
        self.runtime = runtime.Machine(self.own, ("x", "y"))

    def step(self, errors, **told):
        """``told`` is of the x axis; the path goes along x."""
        axes = {
            axis: {"enable": 1.0, "reference": 50.0, "position": 50.0 - error}
            for axis, error in zip("xy", errors, strict=True)
        }
        every = {"x": axes["x"] | told, "y": axes["y"]}
        view = {axis: dict.fromkeys(self.own.connected.units, 0.0) | x for axis, x in every.items()}
        return tuple(self.runtime.step(view, PathView((1.0, 0.0), 0.0, 0.0)).values())


def test_the_axes_of_a_machine_are_on_together():
    """P, and I of one sample, of both PIDs by hand; the contour error of a line along x is -e_y."""
    one = Machine()
    assert one.step((2.0, 1.0), enable=0.0) == (0.0, 0.0)
    own, contour = 3.0 + 20.0 * 0.01, 2.0 + 30.0 * 0.01
    assert one.step((2.0, 1.0)) == pytest.approx((own * 2.0, own * 1.0 + contour * 1.0))


def test_an_axis_that_is_too_far_stops_all_of_a_machine():
    one = Machine()
    assert one.step((2.0, 1.0), largest_error=3.0) != (0.0, 0.0)
    assert one.step((4.0, 1.0), largest_error=3.0) == (0.0, 0.0)
    assert one.step((1.0, 1.0), largest_error=3.0) == (0.0, 0.0)
    one.step((1.0, 1.0), enable=0.0)
    assert 0.0 not in one.step((1.0, 1.0), largest_error=3.0)


def test_what_connected_code_saved_is_taken():
    """It saves more than bare code; what is learnt comes first in both."""
    design = hfc.load_design("jee-koren-2004-aflc")
    for one in (design, connect(design)):
        starts = {field.name: field.start for field in recorded_law(one).fields}
        members = saving.saved(one).members
        numbers = [x for member in members for x in starts.get(member.name, [0.0])]
        numbers[0] = -31.5
        rules = saving.taken(design, numbers).rules.centroids
        assert rules[0][0] == -31.5
    with pytest.raises(ValueError, match=f"has {len(numbers) + 1} numbers"):
        saving.taken(design, [*numbers, 0.0])


@pytest.mark.parametrize("scenario", ["gone", {"name": "x", "plant": {"name": "gone"}}])
def test_of_a_scenario_that_cannot_run_there_is_bare_code_alone(scenario, tmp_path):
    design = hfc.load_design("pd-only")
    own = design.model_copy(update={"provenance": {"scenario": scenario}})
    with pytest.raises(hfc.UserError, match=r"^design pd-only: its sensors are not known"):
        hfc.export(own, "c", tmp_path / "c")
    hfc.export(own, "c", tmp_path / "c", bare=True)


def test_sensors_of_another_scenario(tmp_path):
    hfc.export("pd-only", "c", tmp_path / "c", scenario="c-axis-practical")
    assert "observer" in (tmp_path / "c" / "README.md").read_text()


def test_a_signal_that_no_encoder_forms_is_read_by_its_name():
    """In steps of its own sensor, whatever the model would make it of."""
    fields = ("place", "speed", "warmth")
    sensing = Sensing(
        position="place",
        velocity="speed",
        encoders={"place": "speed"},
        rated=(),
        resolution=None,
        source="tachometer",
        samples=1,
        observer=(0.0, 0.0),
        turn=0.0,
        apart={"warmth": 0.5},
        fields=fields,
        measured=lambda read: read,
        signals=lambda read: {"warmth": 99.0},
    )
    asked = AxisLaw(lambda xp, law, gains, memory, x: (x["warmth"], memory, None), lambda *_: (), 1)
    begins = Begins(lambda xp, fresh, memory: memory, lambda xp, fresh, memory, first: memory)
    law = connected(asked, Connection(sensing, None, None, None), begins)
    memory = law.initial_memory(0.0)
    for told, read in ((7.4, 7.5), (7.7, 7.5), (7.8, 8.0)):
        command, memory, _ = law.sample(SCALARS, law, (), memory, {"warmth": told})
        assert command == read
