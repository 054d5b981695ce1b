"""Resonators beside a hierarchy, alone and shared with the law that its root multiplies."""

import json

import made_up
import numpy as np
import pytest
from scheduled import root, says
from wording import refused

from hfc_design import api
from hfc_design.files.design import Design, design_json, parse_design
from hfc_design.runtime import Controller
from hfc_design.simulation.loop_margins import loop_margins

FREQUENCIES = (3.0, 700.0)


def made(seed, **parts):
    """Two laws with resonators and without integrals."""
    data = made_up.resonating(made_up.scheduling(seed), seed, *FREQUENCIES).model_dump(mode="json")
    for law in ("linear", "scheduled"):
        data["controller"][law]["ki"] = 0.0
    data["controller"] |= parts
    return Design.model_validate(data)


def without(design):
    data = design.model_dump(mode="json")
    for law in ("linear", "scheduled"):
        data["controller"][law].pop("resonators")
    return Design.model_validate(data)


@pytest.mark.parametrize("limit", [None, 60.0])
def test_the_command_by_hand(limit):
    """What both laws drive is one phasor a frequency, r+ = r exp(-i w T) + T e (p - i q)."""
    plain = made(5)
    own, every = plain.controller, plain.controller.sample_time_s
    gains = {
        law: np.array([x.in_phase - 1j * x.quadrature for x in getattr(own, law).resonators])
        for law in ("linear", "scheduled")
    }
    names = list(plain.kind.reads(own))
    rows = np.cumsum(np.random.default_rng(0).normal(0.0, 0.05, (200, len(names))), axis=0)
    controller, base = Controller(made_up.limited(plain, limit)), Controller(without(plain))
    phasors, before, held = np.zeros(2, complex), {}, 0
    for row in rows.tolist():
        told = dict(zip(names, row, strict=True))
        command = base.step(told) + phasors.real.sum()
        expected = np.clip(command, -limit, limit) if limit else command
        assert controller.step(told) == pytest.approx(expected, rel=1e-11, abs=1e-9)
        factor = own.output_scale * root(plain, told, before)
        steps = every * told["error"] * (gains["linear"] + factor * gains["scheduled"])
        winds = (abs(command) > (limit or np.inf)) & (steps.real * command > 0.0)
        phasors = phasors * np.exp(-1j * every * np.array(FREQUENCIES)) + ~winds * steps
        held, before = held + winds.sum(), told
    assert bool(held) == bool(limit)


def test_margins_are_those_of_the_law_that_holds_everywhere():
    """Tables that say 0.02 everywhere: the loop of ``pid+ff`` with the gains of both laws."""
    design = made(7)
    own = design.controller.model_dump(mode="json")
    design = made(7, units=says(0.02, design))

    def both(key, one, other):
        return one[key] + 0.2 * other[key]

    one, other = own["linear"] | own["pd"], own["scheduled"]
    names = {*one["signals"], *other["signals"]}
    every = [{key: law["signals"].get(key, 0.0) for key in names} for law in (one, other)]
    pairs = list(zip(one["resonators"], other["resonators"], strict=True))
    turning = [x | {k: both(k, x, y) for k in ("in_phase", "quadrature")} for x, y in pairs]
    alike = made_up._design(
        "c-axis",
        kind="pid+ff",
        sample_time_s=0.001,
        kp=both("kp", one, other),
        kd=both("kd", one, other),
        signals={key: both(key, *every) for key in names},
        resonators=turning,
    )
    scenario = api.load_scenario("c-axis-ramp", {"simulation.substeps": 4})
    one, other = (loop_margins(each, scenario).rows for each in (design, alike))
    angles = np.linspace(0.01, 3.1, 40)
    for found, expected in zip(one, other, strict=True):
        both_loops = [each.loop.transfer(angles) for each in (found, expected)]
        np.testing.assert_allclose(*both_loops, rtol=1e-6)
        keys = ("stable", "gain_up", "gain_down", "phase_deg", "delay_samples", "sensitivity")
        own, others = ([each.numbers[key] or 0.0 for key in keys] for each in (found, expected))
        assert own == pytest.approx(others, rel=1e-4)


@pytest.mark.parametrize(
    ("law", "frequencies"),
    [("scheduled", [3.0]), ("linear", []), ("linear", [3.0, 4000.0]), ("linear", [700.0, 3.0])],
)
def test_a_file_that_is_none_is_told_in_a_line(law, frequencies):
    data = json.loads(design_json(made(7)))
    gains = {"in_phase": 1.0, "quadrature": 1.0}
    data["controller"][law]["resonators"] = [{"frequency_rad_s": x, **gains} for x in frequencies]
    with refused() as found:
        parse_design(json.dumps(data), "mine.json")
    assert ".resonators" in found.refusal
