"""The self-organising controller: by hand, in the loop, and what Huang & Shy print."""

import numpy as np
import pytest
from wording import refused

import hfc_design.api as hfc
from hfc_design.controllers.kind import ReportContext
from hfc_design.controllers.soc.law import SETS, SocGains, soc
from hfc_design.controllers.soc.record import EMPTY, SocDesign
from hfc_design.controllers.soc.section import learnt, sections
from hfc_design.core.numbers import ARRAYS, SCALARS
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller

SOC = load_design("huang-soc")
#: As printed, of an error in counts and a command in what the table holds.
GAINS = SocGains(ge=1.0, gc=3.0, gu=0.5, gamma=0.5, xi=0.5)


def stepped(errors, gains=GAINS, rules=EMPTY, limit=None):
    """Commands, and the rules in the end."""
    law = soc(rules, 0.005, limit)
    memory, commands = law.initial_memory(0.0), []
    for error in errors:
        command, memory = law.step(SCALARS, gains, memory, {"error": error})
        commands.append(command)
    return commands, np.array(memory.rules)


def test_two_samples_by_hand():
    """e = 1.25, ce = 3.75: a quarter of each lower set, and then the rules that this has moved.

    The correction is 0.5 (0.5 * 1.25 + 0.5 * 3.75) = 1.25; the second sample, of the same error,
    has ce = 0 and meets none of the four.
    """
    commands, rules = stepped([1.25, 1.25])
    assert commands == [0.0, 0.0]
    wanted = np.zeros((SETS, SETS))
    wanted[6:8, 8:10] = 1.25 * np.outer([0.75, 0.25], [0.25, 0.75])
    wanted[6:8, 5] = 0.5 * 0.5 * 1.25 * np.array([0.75, 0.25])
    np.testing.assert_allclose(rules, wanted, atol=1e-15)
    # Once more, from the table that it has learnt: 0.5 times the average of the four rules.
    again, _ = stepped([1.25], rules=rules)
    weights = np.outer([0.75, 0.25], [0.25, 0.75])
    assert again[0] == pytest.approx(0.5 * (weights * wanted[6:8, 8:10]).sum())


def test_rules_stop_where_the_command_does():
    """At 2 V a rule of 4: it comes back at once, and does not wind up."""
    commands, rules = stepped([3.0] * 50, limit=2.0)
    assert rules.max() == 4.0
    assert max(commands) == 2.0
    _, after = stepped([-3.0, 3.0], rules=rules, limit=2.0)
    assert after.max() == 4.0
    free, unbound = stepped([3.0] * 50)
    assert unbound.max() > 30.0
    assert max(free) > 15.0


def test_many_at_once_are_as_each_alone():
    errors = np.cumsum(np.random.default_rng(1).normal(0, 1.0, (60, 4)), axis=0)
    law = soc(EMPTY, 0.005, 3.0)
    memory = law.initial_memory(np.zeros(4))
    for k, row in enumerate(errors):
        command, memory = law.step(ARRAYS, GAINS, memory, {"error": row})
        if k == len(errors) - 1:
            alone = [stepped(column, limit=3.0)[0][-1] for column in errors.T]
            np.testing.assert_allclose(command, alone, rtol=1e-13)


def test_what_was_learnt_is_a_design_that_goes_on():
    """The runtime with the saved table does what it would have done without a break."""
    errors = (0.2 * np.sin(np.arange(400) / 30.0)).tolist()
    whole, first = Controller(SOC), Controller(SOC)
    for error in errors[:200]:
        whole.step({"error": error})
        first.step({"error": error})
    saved = SOC.model_copy(update={"controller": first.adapted()})
    again = Controller(parse_design(design_json(saved), "again"))
    again.remember({"error": errors[199]})
    for error in errors[200:]:
        assert again.step({"error": error}) == whole.step({"error": error})


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("table", [[0.0] * 11] * 10),
        ("ge", 0.0),
        ("adaptation.xi", 1.2),
    ],
)
def test_bad_designs_are_one_line(key, value):
    with refused() as found:
        load_design("huang-soc", {f"controller.{key}": value})
    assert f"controller.{key}" in found.refusal


def test_searched_gains_are_those_of_the_design():
    """Per mm and in V, with an empty table."""
    genome = genome_of(hfc.load_scenario("milling-table-sine"))
    population = genome.fresh(np.zeros(6, int), np.random.default_rng(0))
    gains = genome.gains(population)
    for k in range(6):
        one = type(population)(*(leaf[k : k + 1] for leaf in population))
        record = SocDesign(sample_time_s=0.005, **genome.record(one))
        assert record.law_gains() == pytest.approx([leaf[k] for leaf in gains])
        assert record.table == EMPTY


def test_printed_gains_count_in_their_units():
    """1, 3 and 0.5 of tenths of a mm and of 10 V."""
    record = hfc.load_design("huang-soc").controller
    assert record.law_gains() == pytest.approx((10.0, 30.0, 5.0, 0.5, 0.5))


def test_the_report_shows_the_rules_as_the_runtime_learns_them():
    design = hfc.load_design("huang-soc")
    scenario = hfc.load_scenario("milling-table-circle")
    errors = 0.3 * np.sin(np.arange(200) / 25.0)
    signals = {"x": {"error": errors}, "y": {"error": -errors}}
    machine, parameters = scenario.machine, scenario.plant.values()
    shown = ReportContext(machine, parameters, signals, largest=(10.0, 10.0))
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
        "Heat maps of the rules learned by X",
        "Rules of X at the end: rules over error and change of error in a sample",
        "Heat maps of the rules learned by Y",
        "Rules of Y at the end: rules over error and change of error in a sample",
    ]
    assert len(sections(design.controller, shown._replace(signals=None))) == 1


def test_an_error_beyond_the_sets_counts_as_the_outermost():
    for error in (5.0, 80.0, 1e300):
        _, rules = stepped([error])
        wanted = np.zeros((SETS, SETS))
        wanted[10, 10] = 0.5 * (0.5 * 5 + 0.5 * 5)
        np.testing.assert_array_equal(rules, wanted)
