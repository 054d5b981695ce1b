"""Linear laws as rule tables along trees: by hand, by SciPy, and what they are worth at once."""

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.linear_tables import linear_chain, passthrough
from hfc_design.controllers.hierarchical.seed_laws import Laws, SeedLaws
from hfc_design.controllers.linear import genome as linear
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import genome_of

#: The seven terms of LL eq. 3 fit a line to this within half the universe; a value meets it once in
#: each unit on its way to the root.
LINE = 0.0145


def genome(name="c-axis-ramp", *changes):
    return genome_of(load_scenario(name, list(changes)))


def said(own, tables, tree, inputs):
    """What the root says of scaled inputs, by the definition of a unit (LL eq. 3 and 4)."""
    values = [*inputs]
    for unit, table in zip(own.trees[tree], tables, strict=True):
        shares = []
        for u in (values[unit.column], values[unit.row]):
            far = [max(abs(u - t.centre) - t.half_width, 0.0) for t in own.settings.terms]
            degrees = np.exp(
                [-t.rate * x * x for t, x in zip(own.settings.terms, far, strict=True)]
            )
            shares.append(degrees / degrees.sum())
        values.append(float(shares[1] @ table @ shares[0]))
    return values[-1]


def test_tables_along_every_tree_add_up_to_the_law():
    own = genome()
    rng = np.random.default_rng(0)
    slopes = rng.uniform(-1.0, 1.0, (own.structures, 5))
    slopes[rng.random(slopes.shape) < 0.2] = 0.0
    tree = np.arange(own.structures)
    sources = hierarchy.all_sources(5)[tree].astype(int)
    tables = linear_chain(
        sources, slopes, np.full((own.structures, 4), 1.0), passthrough(own.settings)
    )
    for k in tree.tolist():
        for inputs in rng.uniform(-0.5, 0.5, (5, 5)):
            wrong = said(own, tables[k], k, inputs) - slopes[k] @ inputs
            assert abs(wrong) < 4.5 * LINE * np.abs(slopes[k]).sum()


def test_laws_are_regulators_of_the_drive():
    """One that weighs some signals is SciPy's for the same weights; the PD gets its two gains."""
    scenario = load_scenario("c-axis-ramp")
    own = SeedLaws(genome_of(scenario))
    assert own.search.signals == ("deflection", "deflection_rate")
    assert own.velocities == {"spindle_velocity": -1.0}
    found = own.search.fresh(np.zeros(3, int), np.random.default_rng(1))
    gains, weights = own.search.gains(found), own.search.values(found)
    told = own.search.states
    for k in range(3):
        cost = np.diag([weights[name][k] ** 2 for name in told.names])
        b = told.b[:, None]
        value = solve_discrete_are(told.a, b, cost, np.eye(1))
        wanted = -np.linalg.solve(1.0 + b.T @ value @ b, b.T @ value @ told.a)[0]
        have = [gains.kp[k], gains.kd[k], *gains.signals[:, k]]
        assert have == pytest.approx(wanted, rel=1e-6, abs=1e-6 * abs(wanted).max())


def test_tables_make_the_law():
    """What the root says against the law's numbers, in volts, as well as tables follow lines."""
    own = genome("c-axis-ramp", "search.scale_range=1.0")
    laws = SeedLaws(own)
    numbers = np.array([[800.0, 120.0, 300.0, -20.0, 500.0, 3.0]])
    assert laws.signals == ("deflection", "deflection_rate")
    points = np.column_stack([laws.points(Laws(np.zeros(1, int), numbers)), [[0.0, np.log(0.25)]]])
    wanted = {"deflection": 300.0, "deflection_rate": -20.0, "spindle_velocity": -500.0}
    wanted["previous_spindle_velocity"] = 500.0
    rng = np.random.default_rng(7)
    for tree in range(0, 105, 13):
        found = laws.laid(points, np.array([tree]), 1.0 / np.array(own.scales))
        assert found.gains[0].tolist() == pytest.approx([800.0, 120.0])
        slopes = np.array([wanted.get(name, 0.0) for name in own.names]) / found.scales[0]
        tables = found.consequents[0]
        assert 10.0 * said(own, tables, tree, np.zeros(5)) == pytest.approx(3.0, abs=1e-6)
        for inputs in rng.uniform(-0.5, 0.5, (20, 5)):
            wrong = 10.0 * said(own, tables, tree, inputs) - 3.0 - slopes @ inputs
            assert abs(wrong) < 4.5 * LINE * np.abs(slopes).sum()


def test_a_drive_that_cannot_be_linearised_begins_at_random(monkeypatch):
    def no(*_):
        raise UserError("the drive cannot be linearised")

    monkeypatch.setattr(linear, "nominal", no)
    assert genome().informed(np.zeros(3, int), np.random.default_rng(0)) is None


def test_units_of_which_nothing_is_asked_say_nothing_to_the_root():
    own = genome()
    sources = hierarchy.all_sources(5).astype(int)
    slopes, reach = np.zeros((own.structures, 5)), np.ones((own.structures, 4))
    tables = linear_chain(sources, slopes, reach, passthrough(own.settings))
    assert (tables[:, -1] == 0.0).all()
    assert (np.abs(tables[:, :-1]).max(axis=(2, 3)) > 1.0).all()  # but would pass something on


def test_first_individuals_stay_within_the_bounds():
    changes = ("search.inner_limit=0.5", "search.root_limit=3.0", "search.scale_range=1.0")
    own = genome("c-axis-ramp", *changes)
    tree = np.repeat(np.arange(own.structures), 2)
    found = own.informed(tree, np.random.default_rng(2))
    assert np.array_equal(found.tree, tree)
    assert np.abs(found.consequents[:, :-1]).max() <= 0.5
    assert np.abs(found.consequents[:, -1]).max() <= 3.0
    assert (found.scales == [item.scale for item in own.settings.inputs]).all()


def test_velocities_that_are_read_twice_share_their_universe():
    own = genome()
    found = own.informed(np.zeros(50, int), np.random.default_rng(3))
    assert (found.scales[:, 3] == found.scales[:, 4]).all()
    assert len(np.unique(found.scales[:, 3])) > 40  # but for those at an end


def test_points_and_laws_are_one_another():
    laws = SeedLaws(genome())
    some = laws.fresh(50, np.random.default_rng(6))
    small = np.abs(some.numbers[:, -2]) < laws.most
    again = laws.laws(laws.points(some)).numbers
    assert again[small] == pytest.approx(some.numbers[small], rel=1e-9, abs=1e-6)
    assert (np.abs(again[:, -2]) <= laws.most).all()
