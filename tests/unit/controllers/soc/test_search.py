"""A self-organising controller is searched, shown in a report, and meets machines that vary."""

import numpy as np
import pytest

import hfc_design.api as hfc
from hfc_design.controllers.kind import Shown
from hfc_design.controllers.soc.record import EMPTY, SocDesign
from hfc_design.controllers.soc.section import learnt, sections
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller
from hfc_design.simulation.machines import drawn


def test_searched_gains_are_those_of_the_design():
    """Per mm and in V, with an empty table."""
    genome = genome_of(hfc.load_scenario("milling-table-sine"))
    population = genome.fresh(np.zeros(6, int), np.random.default_rng(0))
    gains = genome.gains(population)
    for k in range(6):
        one = type(population)(*(leaf[k : k + 1] for leaf in population))
        record = SocDesign(sample_time_s=0.005, **genome.record(one))
        assert record.gains() == pytest.approx([leaf[k] for leaf in gains])
        assert record.table == EMPTY


def test_printed_gains_count_in_their_units():
    """1, 3 and 0.5 of tenths of a mm and of 10 V."""
    record = hfc.load_design("huang-soc").controller
    assert record.gains() == pytest.approx((10.0, 30.0, 5.0, 0.5, 0.5))


def test_the_report_shows_the_rules_as_the_runtime_learns_them():
    design = hfc.load_design("huang-soc")
    scenario = hfc.load_scenario("milling-table-circle")
    errors = 0.3 * np.sin(np.arange(200) / 25.0)
    signals = {"x": {"error": errors}, "y": {"error": -errors}}
    machine, parameters = scenario.machine, scenario.plant.values()
    shown = Shown(machine, parameters, signals, largest=(10.0, 10.0))
    controller, found = Controller(design), learnt(design.controller, signals["x"], 10.0)
    tables = {}
    for count, error in enumerate(errors.tolist(), 1):
        controller.step({"error": error})
        tables[0.005 * count] = controller.adapted().table
    assert list(found) == pytest.approx([0.02, 0.25, 1.0])
    for time, rules in found.items():
        np.testing.assert_array_equal(rules, tables[time])
    gains, learning = sections(design.controller, shown)
    assert ["gu, command of a rule of 1", "5", "V"] in gains.listing.rows
    assert [drawing.alt for drawing in learning.drawings] == [
        "Heat maps of the rules that X has learnt",
        "Rules of X at the end: rules over error and change of error in a sample",
        "Heat maps of the rules that Y has learnt",
        "Rules of Y at the end: rules over error and change of error in a sample",
    ]
    assert len(sections(design.controller, shown._replace(signals=None))) == 1


def test_backlash_and_friction_vary_each_in_its_own_tolerance():
    """0.2 to 0.6 mm and 30 %, of each axis its own, all else nearly as it is."""
    plant = hfc.load_scenario("milling-table-circle").plant
    spread = {"backlash": 0.5, "coulomb_friction": 0.3, "stiction_rise": 0.3}
    machines, _ = drawn(plant, 1e-6, 300, 0, spread)
    x, y = machines.true
    assert (x.backlash.min(), x.backlash.max()) == pytest.approx((0.2, 0.6), abs=0.01)
    friction = x.coulomb_friction.min(), x.coulomb_friction.max()
    assert friction == pytest.approx((210.0, 390.0), abs=3.0)
    assert x.stiffness == pytest.approx(5e4, rel=2e-6)
    assert abs(np.corrcoef(x.backlash, y.backlash)[0, 1]) < 0.2
    assert (x.lead == 5.0).all()
