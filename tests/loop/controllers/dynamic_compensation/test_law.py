"""Dynamic compensation: five principles of LG09, the edge of its dead zone, what is told."""

import numpy as np
import pytest
from two_axes import K_P, ZONE, compensated
from wording import refused

from hfc_design import api
from hfc_design.controllers.genome import taken
from hfc_design.controllers.kind import ReportContext
from hfc_design.files.loop_setup import population_of_one
from hfc_design.runs import individuals
from hfc_design.runtime import Machine


def searched(**changes):
    """On the circle of the feed drives."""
    inner = {"kind": "fuzzy-sliding"}
    own = {"kind": "dynamic-compensation", "inner": inner, "k_p": K_P}
    own |= {"dead_zone": ZONE, "programmed_speed": 1256.0, **changes}
    return {"controller": own, "limits.command": 120.0}


def test_an_individual_is_the_design_that_it_writes():
    scenario = api.load_scenario("feed-drive-circle", searched())
    own, rng = individuals.genome_of(scenario), np.random.default_rng(0)
    population = own.mutated(own.fresh(np.zeros(8, int), rng), np.full(8, 0.5), rng)
    many = own.gains(population)
    for k in (0, 5):
        written = individuals.design_of(taken(population, slice(k, k + 1)), scenario)
        alone = population_of_one(written.controller.law_gains())
        for key in ("k_p", "dead_zone", "speed"):
            one, each = np.array(getattr(alone, key)), np.array(getattr(many, key))
            np.testing.assert_allclose(one[..., 0], each[..., k], rtol=1e-12)
        np.testing.assert_allclose(alone.inner.slope[0], many.inner.slope[k], rtol=1e-12)
    assert np.ptp(many.dead_zone) > 0.0
    assert np.ptp(many.inner.slope) > 0.0


@pytest.mark.parametrize(
    ("scenario", "changes", "key"),
    [
        ("feed-drive-circle", {"k_p": {"x": 1.0}}, "k_p"),
        (
            "feed-drive-circle",
            {"inner": {"kind": "fuzzy-sliding", "start": "jee-koren-2004-flc"}},
            "inner.start",
        ),
        ("c-axis-ramp", {"k_p": {"axis": 1.0}}, "inner.start"),
    ],
)
def test_what_cannot_be_searched_is_told(scenario, changes, key):
    with refused() as found:
        api.load_scenario(scenario, searched(**changes))
    assert f"controller.{key}" in found.refusal


def test_the_simulator_does_as_the_runtime():
    """Commands of a motion, one by one, up to the rounding to whole units."""
    inner = {"kind": "pid", "pid": {"k_p": 1.5, "k_i": 8.1, "k_d": 0.02}}
    two = compensated(limit=100.0, inner=inner, programmed_speed=1256.0)
    scenario = api.load_scenario("feed-drive-circle", {"simulation.duration_s": 1.0})
    found, machine, samples = api.evaluate(two, scenario), Machine(two), scenario.samples()
    for k in range(100):
        told = {}
        for name, axis, row in zip("xy", found.axes, samples.axes, strict=True):
            error = float(row.reference[k] - np.round(axis.motion.state.position[k]))
            rate = float(row.reference_rate[k])
            told[name] = {"error": error, "reference_rate": rate, "error_rate": 0.0}
        for axis, command in zip(found.axes, machine.step(told).values(), strict=True):
            assert axis.motion.command[k] == np.round(command)


def test_its_section_has_the_units_of_each_axis():
    name = "lin-gai-2009-fuzzy-sliding-compensated"
    found, plant = api.load_design(name), api.load_scenario("five-axis-program").plant
    first, *inner = found.kind.sections(
        found.controller, ReportContext(plant.machine, plant.values(), None)
    )
    rows = {row: (value, unit) for row, value, unit in first.listing.rows}
    assert rows["gain of X, k_p"] == ("0.53328", "V/mm")
    assert rows["gain of A, k_p"] == ("0.79992", "V/deg")
    assert rows["programmed speed, v, of X, Y, Z"][0] == "166.667"
    assert [section.title for section in inner] == [f"{axis}: The controller" for axis in "xyzac"]
