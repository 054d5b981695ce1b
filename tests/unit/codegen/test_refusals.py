"""What a law may not do of which code is to be made: refused with the line of the law."""

import inspect
import math
from itertools import count

import pytest

from hfc_design.codegen import recorder, st
from hfc_design.codegen.c import program
from hfc_design.codegen.nodes import TraceError
from hfc_design.codegen.recorded import of_axis, recorded
from hfc_design.controllers.controller import AxisLaw


def told(sample):
    """The line of the refusal of a law."""
    law = AxisLaw(sample, lambda law, zero: (), 0.01)
    with pytest.raises(TraceError) as caught:
        recorded(of_axis(law, (2.0,), ["error"], None))
    return str(caught.value)


def branches(xp, law, gains, memory, signals):
    if signals["error"] > 1.0:
        return signals["error"], memory, None
    return 0.0 * signals["error"], memory, None


def calls_math(xp, law, gains, memory, signals):
    return math.sin(signals["error"]), memory, None


def repeats(xp, law, gains, memory, signals):
    command = signals["error"]
    for k in count():
        command = command + float(k) * signals["error"]
    return command, memory, None


def waits(xp, law, gains, memory, signals):
    command = signals["error"]
    while command < 5.0:
        command = command + 1.0
    return command, memory, None


def mixes(xp, law, gains, memory, signals):
    return signals["error"] + "1", memory, None


def cubes(xp, law, gains, memory, signals):
    return signals["error"] ** 3, memory, None


def goes_through(xp, law, gains, memory, signals):
    return sum(signals["error"]), memory, None


def keeps_what_was(xp, law, gains, memory, signals):
    rows = xp.put(xp.stored(xp.along(lambda k: signals["error"] * k, range(20))), [(3, 1.0)])
    return rows[3] + rows.base[3], memory, None


@pytest.mark.parametrize(
    ("sample", "line", "what"),
    [
        (branches, 1, "branches on a value"),
        (calls_math, 1, "needs the number of a value"),
        (repeats, 3, "is a loop endless"),
        (waits, 2, "branches on a value"),
        (mixes, 1, "computes with '1', which is not a number"),
        (cubes, 1, "power"),
        (goes_through, 1, "uses a number as a sequence"),
        (keeps_what_was, 2, "after it has replaced some"),
    ],
)
def test_the_line_of_the_law_is_named(sample, line, what, monkeypatch):
    monkeypatch.setattr(recorder, "MOST", 1000)
    place = f"{__file__}:{inspect.getsourcelines(sample)[1] + line}: "
    found = told(sample)
    assert found.startswith(place)
    assert what in found


def test_what_a_design_fixes_may_be_branched_on():
    def sample(xp, law, gains, memory, signals):
        factor = 3.0 if gains[0] > 1.0 and law.sample_time < 1.0 else 4.0
        return factor * signals["error"] * math.sin(gains[0]), memory, None

    law = AxisLaw(sample, lambda law, zero: (), 0.01)
    assert recorded(of_axis(law, ({"gain": 2.0}["gain"],), ["error"], None)).commands


def test_what_a_law_remembers_in_rows_is_checked_before_it_is_kept():
    """Of a law that does not promise that its command tells."""

    def sample(xp, law, gains, memory, signals):
        return signals["error"], xp.along(lambda x: x + signals["error"], memory), None

    law = AxisLaw(sample, lambda law, zero: [zero] * 30, 0.01)
    found = program(recorded(of_axis(law, (2.0,), ["error"], None)))
    text = "\n".join(found.law)
    assert text.index("overflow <= 0") < text.rindex("state->memory[")
    assert "for (int" in text


@pytest.mark.parametrize("name", ["tan", "atan2", "log1p"])
def test_a_function_that_structured_text_has_not_is_refused(name):
    """Whatever digits are in its name; a law has it through ``jax.numpy``."""

    def sample(xp, law, gains, memory, signals):
        x = signals["error"]
        args = (x, 2.0 * x) if name == "atan2" else (x,)
        return x.block.trace.made(name, *args), memory, None

    law = AxisLaw(sample, lambda law, zero: (), 0.01)
    found = recorded(of_axis(law, (2.0,), ["error"], None), flat=True)
    with pytest.raises(TraceError, match=f"calls {name}, which Structured Text does not have"):
        st.program(found, ["command"])
