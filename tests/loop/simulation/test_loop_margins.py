"""Margins that a scenario asks for: what a search takes for them against the exact loops."""

from types import SimpleNamespace
from typing import Any, NamedTuple

import jax
import numpy as np
import pytest
from scipy.signal import butter, freqz, iirnotch
from wording import refused

from hfc_design import api
from hfc_design.files.loop_setup import controller_of
from hfc_design.objectives.judge import Judged
from hfc_design.objectives.verdict import Ensemble
from hfc_design.runs.problem import Problem, drawn_for
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.linearised import controlled
from hfc_design.simulation.loop_margins import (
    AskedMargins,
    _why,
    loop_margins,
    near,
    operating_points,
)
from hfc_design.simulation.population import one_machine
from hfc_design.simulation.stress import Applied, rubbing
from hfc_design.stability.margins import ASKED

#: Factors on a gain that damps.
KD = (0.3, 1.0, 3.0)


@pytest.mark.parametrize("name", ["lin-lee-1999-table-2", "pd-only"])
def test_what_a_search_takes_for_margins_is_near_the_exact_ones(name):
    """At the same points, from 64 frequencies; where there is no end there is none.

    The gain beside the resonance of the transmission, where the loop turns fast, is rougher, and so
    is the compliance of the PD, which has a sharp peak between two frequencies.
    """
    rough = {"gain_margin": 0.1, "compliance": 0.02}
    scenario = api.load_scenario("c-axis-ramp", {"constraints.compliance": 1.0})
    design = api.load_design(name)
    controller, gains = controller_of(design, scenario)
    asked = AskedMargins(scenario, closed_loop(scenario, controller))
    found = asked.margins(gains)
    for k, row in enumerate(loop_margins(design, scenario).rows):
        for what, (key, _, _) in ASKED.items():
            expected = row.numbers[key]
            if expected is None:
                assert found[what][k, 0] == np.inf
            else:
                share = rough.get(what, 0.01)
                assert found[what][k, 0] == pytest.approx(expected, rel=share)


def test_who_breaks_more_ranks_lower_and_who_keeps_all_is_left_alone():
    """By hand: Ms over what is allowed, 1 % stricter, x/(1 + x) of what it is over."""
    gains, names = [], ("pd-only", "lin-lee-1999-table-2")
    for name in names:
        design = api.load_design(name)
        most = 2.0
        scenario = api.load_scenario("c-axis-ramp", {"constraints.sensitivity": most})
        controller, own = controller_of(design, scenario)
        asked = AskedMargins(scenario, closed_loop(scenario, controller))
        *each, _ = asked.margins(own)["sensitivity"]  # the last is the law at rest, in motion
        largest = np.max(each)
        over = max(largest * 1.01 / most - 1.0, 0.0)
        twice = jax.tree.map(lambda leaf: np.repeat(leaf, 2, axis=-1), own)
        assert asked.broken(twice) == pytest.approx([over / (1.0 + over)] * 2)
        gains.append(over)
    assert max(gains) > 0.0
    merits = np.ones((2, 1, 1))
    judged = Judged(merits, np.zeros((2, 1, 1, 0)), np.zeros((2, 1, 1), bool))
    found = Ensemble((1.0,)).verdict(judged, more_violation=np.array([0.0, 0.25]))
    np.testing.assert_array_equal(found.rank, [1.0, -0.25])
    assert Ensemble((1.0,)).best_rank(judged, 4, np.array([0.0, 0.25]))[1] == -0.25


def test_an_unstable_loop_is_broken_however_small_its_sensitivity_is():
    """A PD that pushes the wrong way, of which exact poles say that it runs away."""
    scenario = api.load_scenario("c-axis-ramp", {"constraints.sensitivity": 99.0})
    design = api.load_design("pd-only")
    controller, gains = controller_of(design, scenario)
    asked = AskedMargins(scenario, closed_loop(scenario, controller))
    assert asked.broken(gains) == 0.0
    away = gains._replace(kp=-gains.kp)
    assert (asked.margins(away)["sensitivity"] < 90.0).all()
    assert asked.broken(away) > 0.01
    pd = design.controller.pd.model_copy(update={"kp": -design.controller.pd.kp})
    wrong = design.controller.model_copy(update={"pd": pd})
    rows = loop_margins(design.model_copy(update={"controller": wrong}), scenario).rows
    assert [row.numbers["stable"] for row in rows] == [True, False]  # at rest friction holds it


def test_a_machine_that_a_stress_just_does_not_forgive_must_not_grow_as_it_slides():
    """Of 200 with twice the friction a tenth may break; the 11th, 14th, 17th and 20th are asked.

    Those that stick most come first. Whether loops grow is known from their poles (``hfc
    stability``).
    """
    changes = {
        "constraints.sensitivity": 99.0,
        "robust": {"spread": 1e-6, "tolerances": {"static_torque": 0.5}, "final": 24},
        "stress": {"friction": 2.0, "share": 0.9},
        "reference": {"kind": "ramp", "velocity": 0.005},
        "plant.parameters.stribeck_velocity": 0.02,
    }
    scenario = api.load_scenario("c-axis-ramp", changes)
    machines = rubbing(scenario, drawn_for(scenario, 199, 7), Applied(friction=2.0))
    some = np.argsort(-machines.actual[0].static_torque)[[10, 13, 16, 19]]
    design = api.load_design("pd-only")
    controller, gains = controller_of(design, scenario)
    loop, found = closed_loop(scenario, controller, 1.0), []
    calm, asked = AskedMargins(scenario, loop), AskedMargins(scenario, loop, machines)
    for part in KD:
        own = gains._replace(kd=part * gains.kd)
        pd = design.controller.pd.model_copy(update={"kd": part * design.controller.pd.kd})
        law = design.controller.model_copy(update={"pd": pd})
        own_design = design.model_copy(update={"controller": law})
        each = (loop_margins(own_design, scenario, machines.take(k[None])) for k in some)
        grows = any(not one.rows[-1].numbers["stable"] for one in each)
        found.append(grows)
        assert (asked.broken(own) > calm.broken(own)) == grows
    assert set(found) == {False, True}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("sensitivity", 0.9),
        ("sensitivity", "2 V"),
        ("gain_margin", 1.0),
        ("phase_margin_deg", 200.0),
        ("delay_margin_samples", -1.0),
        ("closed_loop_peak", 0.5),
    ],
)
def test_a_margin_that_no_loop_can_have_is_told_in_a_line(key, value):
    with refused() as found:
        api.load_scenario("c-axis-ramp", {f"constraints.{key}": value})
    assert key in found.refusal


@pytest.mark.parametrize("gap", [0.0, 0.3])
def test_a_gap_is_said_to_be_why_there_is_no_steady_motion(gap):
    own = api.load_scenario("milling-table-sine").machine.drives[0].parameters(backlash=gap)
    about, machine = SimpleNamespace(exists=[False]), SimpleNamespace(actual=(own,))
    told = _why(None, about, None, 0, machine)
    assert told.startswith("with its backlash " * (gap > 0.0) + "no steady motion was found there")


class Gain(NamedTuple):
    """What is searched."""

    kp: Any


def test_margins_of_an_own_law_that_cannot_be_differentiated(own_plugins):
    """As one that leaves JAX: it needs the number itself."""

    def step(sample_time, gains, memory, signals):
        return 3.0 * float(signals["error"]), memory

    api.register(api.Law("outside", Gain((1e4, 1e6)), lambda zero: (), step))
    changes = {"controller": {"kind": "outside"}, "robust.spread": 0.1}
    with refused() as found:
        Problem(api.load_scenario("c-axis-ramp", changes | {"constraints.sensitivity": 2.0}))
    assert found.where == "controller 'outside' cannot be linearised"
    assert Problem(api.load_scenario("c-axis-ramp", changes)).task.broken is None


@pytest.mark.parametrize(("sign", "broken"), [(1.0, False), (-1.0, True)])
def test_a_robust_search_without_margins_still_keeps_loops_that_the_answer_calls_stable(
    sign, broken
):
    """A PD, and one that pushes the wrong way, of which exact poles say that it runs away."""
    scenario = api.load_scenario("c-axis-ramp", {"robust.spread": 0.1})
    controller, gains = controller_of(api.load_design("pd-only"), scenario)
    asked = Problem(scenario)._margins.of(controller)
    assert (asked.broken(gains._replace(kp=sign * gains.kp))[0] > 0.0) == broken


def test_filters_of_a_command_are_factors_of_the_open_loop():
    """At a speed and at rest, as SciPy has them."""
    scenario, hz = api.load_scenario("c-axis-ramp"), np.array([3.0, 20.0, 60.0, 300.0])
    gains = {"kp": 3000.0, "ki": 500.0, "kd": 900.0}
    filters = {"notch_hz": 50.0, "notch_width": 0.2, "notch_depth": 0.0, "lowpass_hz": 120.0}
    designs = [api.with_gains(scenario, "pid+ff", gains | more) for more in ({}, filters)]
    pairs = zip(*(loop_margins(design, scenario).rows for design in designs), strict=True)
    width = np.arctan(0.5 * 0.2 * np.sin(2e-3 * np.pi * 50.0)) / np.pi * 1e3
    each = butter(2, 120.0, fs=1e3), iirnotch(50.0, 50.0 / width, 1e3)
    factor = np.prod([freqz(*one, hz, fs=1e3)[1] for one in each], axis=0)
    for pair in pairs:
        plain, other = (row.loop.transfer(2e-3 * np.pi * hz) for row in pair)
        np.testing.assert_allclose(other / plain, factor, rtol=1e-6)


def test_far_off_where_its_tables_have_ended_a_hierarchy_answers_an_error_as_its_pd_alone():
    scenario = api.load_scenario("c-axis-ramp")
    design = api.load_design("lin-lee-1999-table-1")
    controller, gains = controller_of(design, scenario)
    loop, points = closed_loop(scenario, controller), operating_points(scenario)
    about = near(loop, one_machine(scenario.plant.values()), points)
    every = jax.tree.map(lambda leaf: np.repeat(leaf, len(points), axis=-1), gains)
    kp = design.controller.pd.kp
    (error,) = np.flatnonzero(about.off[0, :, 0] > 0.5)
    for off in (-1e6, 1e6):
        own = controlled(loop, (), every, about, np.full(len(points), off))
        assert own.d[:, 0, error] == pytest.approx(kp, rel=1e-9)
    bent = controlled(loop, (), every, about).d[:, 0, error]
    assert (np.abs(bent / kp - 1.0) > 2e-3).any()


@pytest.mark.parametrize(("above", "asked"), [({}, False), ({"unknown_above_hz": 100.0}, True)])
def test_far_off_margins_are_asked_where_a_log_does_not_tell_of_every_mode(above, asked):
    """Table I has an Ms of 3.447 about the reference and of 3.470 beyond its tables."""
    changes = {"constraints.sensitivity": 2.0, "robust.spread": 0.1, "stress": above}
    scenario = api.load_scenario("c-axis-ramp", changes)
    controller, gains = controller_of(api.load_design("lin-lee-1999-table-1"), scenario)
    found = AskedMargins(scenario, closed_loop(scenario, controller))
    assert (found.margins(gains)["sensitivity"].max() > 3.46) == asked


def test_between_the_frequencies_of_a_search_finalists_are_looked_at_where_damping_is_light():
    """Three times the damping of a PD is near to what makes the transmission swing at rest."""
    scenario = api.load_scenario("c-axis-ramp", {"constraints.sensitivity": 2.0})
    design = api.load_design("pd-only")
    pd = design.controller.pd.model_copy(update={"kd": 3.0 * design.controller.pd.kd})
    law = design.controller.model_copy(update={"pd": pd})
    controller, gains = controller_of(
        own := design.model_copy(update={"controller": law}), scenario
    )
    exact = [row.numbers["sensitivity"] for row in loop_margins(own, scenario).rows]
    rough, near = (
        AskedMargins(scenario, closed_loop(scenario, controller), narrow=narrow).margins(gains)
        for narrow in (False, True)
    )
    assert near["sensitivity"][: len(exact), 0] == pytest.approx(exact, rel=0.01)
    assert rough["sensitivity"][0, 0] < 0.1 * exact[0]
