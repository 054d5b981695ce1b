"""Whether a design can be used: against runs of its own, poles, and the constraints by hand."""

import numpy as np
import pytest
from places import DATA

from hfc_design.api import with_gains
from hfc_design.core.statistics import share_interval
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.acceptance import merit_text
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.repeats import FACTORS
from hfc_design.simulation.usable import BEYOND, usable

#: Two motions of a second, with tolerances and a bound on the command.
TWO = {
    "name": "two",
    "simulation": {"duration_s": 2.0},
    "fitness": {"settled_after_s": 1.0},
    "robust": {"spread": 0.1, "unseen": 20, "first": 2, "machines": 2, "elite": 2, "final": 2},
    "motions": [
        {"name": "ramp"},
        {"name": "slow", "reference": {"kind": "ramp", "velocity": 0.01}, "weight": 3.0},
    ],
}


def test_machines_are_those_of_a_seed_of_their_own_and_each_moves_as_it_does_alone():
    scenario = load_scenario(TWO, ["run.seed=5"])
    found = usable("pd-only", scenario)
    assert (found.seed, len(found.good), found.spread) == (5 + BEYOND, 20, 0.1)
    assert [one.name for one in found.motions] == ["ramp", "slow"]
    machines, _ = drawn(scenario.plant, 0.1, 20, found.seed)
    for k in (1, 20):
        own = {key: float(v[k]) for key, v in machines.actual[0]._asdict().items()}
        changes = {f"plant.parameters.{key}": value for key, value in own.items()}
        alone = evaluate("pd-only", load_scenario(scenario, changes)).motions
        for one in found.motions:
            (axis,) = alone[one.name].axes
            late = axis.motion.error[alone[one.name].time >= 1.0]
            error = one.measured["settled_rms_error"][k - 1]
            assert error == pytest.approx(np.sqrt(np.mean(late**2)), rel=1e-3)  # float32
            peak = np.abs(axis.motion.command).max()
            assert one.measured["peak_command"][k - 1] == pytest.approx(peak, rel=1e-3)


def test_the_gain_is_kept_up_to_a_bound_on_the_command():
    """The peak of a ramp from rest is about kd times its speed, so the factor scales it."""
    peak = evaluate("pd-only", load_scenario(TWO)).motions["ramp"].metrics["peak_voltage_V"]
    loose = usable("pd-only", load_scenario(TWO, {"constraints.peak_command": 1.3 * peak}))
    assert loose.gain is not None
    low, high = loose.gain
    assert 1.2 < high < 1.35
    assert low < 0.9
    again = load_design(
        "pd-only",
        [f"controller.pd.kp={758.405 * high * 1.02}", f"controller.pd.kd={743.01 * high * 1.02}"],
    )
    beyond = evaluate(again, load_scenario(TWO)).motions["ramp"].metrics["peak_voltage_V"]
    assert beyond > 1.3 * peak
    assert loose.precision < 1e-2
    assert loose.substeps is not None
    assert loose.substeps < 1e-4


def louder(design, factor):
    """The same with its whole command times a factor."""
    gains = design.controller.pd
    changes = {"pd.kp": factor * gains.kp, "pd.kd": factor * gains.kd}
    if "output_scale" in type(design.controller).model_fields:
        changes["output_scale"] = factor * design.controller.output_scale
    return load_design(design, [f"controller.{key}={float(x)!r}" for key, x in changes.items()])


def test_a_millionth_of_the_command_hardly_moves_a_loop_that_is_not_chaotic():
    scenario, design = load_scenario(TWO), load_design("pd-only")
    found = usable(design, scenario)
    ends = sorted(evaluate(louder(design, 1.0 + off), scenario).merit for off in (-1e-6, 1e-6))
    assert [found.repeats.lowest, found.repeats.highest] == pytest.approx(ends, rel=1e-10)
    told = found.numbers()
    assert told["merit"] == pytest.approx(evaluate(design, scenario).merit, rel=1e-10)
    assert not told["chaotic"]
    assert merit_text(told) == ""


def test_a_chaotic_loop_has_a_range_and_no_figure():
    """The best that a search found under the cutting load; each repeat is a run of its own."""
    design, scenario = load_design(DATA / "chaotic.json"), load_scenario("c-axis-ramp-cutting")
    found = usable(design, scenario, machines=8)
    low, high = found.repeats.lowest, found.repeats.highest
    alone = [evaluate(louder(design, factor), scenario).merit for factor in FACTORS[::16]]
    assert max(alone) > 1.01 * min(alone)
    assert high > 1.01 * low
    assert found.numbers()["chaotic"]
    repeats = "in 64 repeats with the command changed by up to one millionth"
    assert (
        merit_text(found.numbers())
        == f"merit is chaotic: {repeats}, it ranges from {low:.4g} to {high:.4g}"
    )


def test_who_keeps_a_constraint_is_counted_with_its_interval():
    free = usable("pd-only", load_scenario(TWO))
    peaks = np.maximum(*(one.measured["peak_command"] for one in free.motions))
    most = float(np.median(peaks))
    found = usable("pd-only", load_scenario(TWO, {"constraints.peak_command": most}))
    np.testing.assert_array_equal(found.good, free.good & (peaks <= most))
    assert found.interval == share_interval(int(found.good.sum()), 20)
    assert not found.yes
    assert found.answer.startswith("no: ")
    assert "peak_command" in found.answer
    numbers = found.numbers()
    assert numbers["share"] == found.good.mean()
    for one in found.motions:
        told = numbers["motions"][one.name]["constraints"]["peak_command"]
        assert told["allowed"] == most
        assert told["nominal"] == one.nominal["peak_command"]
        assert told["largest"] == one.measured["peak_command"].max()


@pytest.mark.parametrize(
    "bound", [{"constraints.peak_command": 1e-3}, {"constraints.late_error": 0.0}]
)
def test_what_no_machine_keeps_is_said_in_a_line(bound):
    found = usable("pd-only", load_scenario(TWO, bound))
    assert not found.good.any()
    assert found.gain is None
    assert found.answer.startswith("no: the nominal machine exceeds ")
    assert "\n" not in found.answer
    assert "0 % of 20 unseen machines" in found.answer


def test_a_loop_that_swings_at_rest_is_of_no_use():
    """The integral is by far too strong for such a drive; the motion is too short to show it."""
    design = load_design("pd-only")
    own = {"kp": design.controller.pd.kp, "kd": design.controller.pd.kd}
    scenario = load_scenario(TWO, {"controller": {"kind": "pid+ff"}})
    calm, wild = (
        usable(with_gains(scenario, "pid+ff", {**own, "ki": ki}), scenario) for ki in (0.0, 1e7)
    )
    assert (calm.loop_stable, wild.loop_stable) == (True, False)
    assert wild.motions[0].nominal_reasons  # as the simulation shows here too
    assert calm.motions[0].nominal_reasons == ()
    good = tuple(one._replace(good=one.good | True) for one in calm.motions)
    assert calm._replace(motions=good).yes
    never = calm._replace(motions=good, margins=wild.margins)
    assert not never.yes
    assert never.answer.startswith(
        "no: the loop is unstable at rest or at speed (see hfc stability"
    )
    short = calm._replace(motions=good, required_margins={"phase_margin_deg": 179.0})
    assert not short.yes
    assert short.answer.startswith("no: phase margin ")
    assert "allowed at least 179" in short.answer
    assert never.numbers()["loop_stable"] is False


def test_a_controller_that_adapts_is_judged_like_the_others():
    """Its copy adapts too; the errors are those of the machine alone."""
    changes = {"simulation.duration_s": 1.0, "fitness.settled_after_s": 0.5}
    changes["run.precision"] = "float64"
    scenario = load_scenario("c-axis-ramp-cutting", changes)
    design = load_design("lin-lee-1999-table-1", {"controller.adaptation": {"largest_move": 1.0}})
    found = usable(design, scenario, spread=0.05, machines=4)
    (motion,) = found.motions
    alone = evaluate(design, scenario)
    (axis,) = alone.axes
    late = axis.motion.error[alone.time >= scenario.fitness.settled_after_s]
    error = np.sqrt(np.mean(late**2))
    assert motion.nominal["settled_rms_error"] == pytest.approx(error, rel=1e-6)
    assert motion.nominal["peak_command"] == pytest.approx(abs(axis.motion.command).max())
    assert len(found.good) == 4
    assert found.gain is None or found.gain[0] <= 1.0 <= found.gain[1]


def test_what_a_scenario_tolerates_and_the_design_misses():
    """Against constraints of the same measures, and the error of the nominal machine alone."""
    free = usable("pd-only", load_scenario(TWO))
    assert free.missed == {}  # of another fitness
    own = {"settled_rms_error": 1e-9, "peak_command": 1e9}
    scenario = load_scenario(TWO, {"fitness": {"kind": "tolerances", "tolerances": own}})
    found = usable("pd-only", scenario)
    assert set(found.missed) == {"settled_rms_error"}  # the other one is kept
    medians = {one.name: np.median(one.measured["settled_rms_error"]) for one in free.motions}
    worst = max(medians, key=medians.get)
    one = found.missed["settled_rms_error"]
    assert one["motion"] == worst
    assert one["times"] == pytest.approx(medians[worst] / 1e-9, rel=1e-3)
    assert found.yes == free.yes
    assert found.answer == free.answer
    told = found.numbers()["motions"]["slow"]["tolerances"]["peak_command"]
    assert told["allowed"] == 1e9
    assert told["largest"] == found.motions[1].measured["peak_command"].max()
    assert f"settled_rms_error {one['times']:.3g} times"[:24] in repr(found)


def test_a_design_that_diverges_everywhere():
    wild = load_design("pd-only", ["controller.pd.kd=1e9"])
    found = usable(wild, load_scenario(TWO))
    assert found.answer.startswith("no: the nominal machine diverges in ramp")
    assert found.numbers()["precision"] is None
