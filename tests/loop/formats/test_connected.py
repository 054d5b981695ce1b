"""What a connected controller does when it is switched, by hand (docs/machine.md)."""

from itertools import pairwise
from math import exp

import pytest
from connections import simulated

import hfc_design.api as hfc
from hfc_design.core.numbers import SCALARS
from hfc_design.formats.connection import connect

K_P, K_I, EVERY = 1.5, 8.1, 0.01  # of jee-koren-2004-pid


class Stepped:
    """The connected PID of a feed drive, whose scale reads whole BLU, sample by sample."""

    def __init__(self):
        design = connect(hfc.load_design("jee-koren-2004-pid"))
        self.gains = design.kind.gains(design.controller)
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
    gains = design.kind.gains(design.controller)
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


def test_the_first_command_has_no_kick():
    assert Stepped().step(2.0) == pytest.approx(FIRST)


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
    connected = connect(design)
    one.law = connected.connected.around(design.kind.law(design.controller, None))
    found = [one.step(50.0) for _ in range(3)]
    assert found == pytest.approx([1.0, 2.0, 3.0])
    one.step(50.0, enable=0.0)
    assert one.step(50.0) == pytest.approx(1.0)
