"""Sectors of rule tables against loops over the rules and against JK04's equations."""

import numpy as np
import pytest
from feed_oracle import output as command
from hypothesis import given, settings
from hypothesis import strategies as st
from jk04 import CHANGE_TERMS, ERROR_TERMS, bilinear, confined, k2_of_rule_base_1, rule_singletons
from shaken import shaken
from wording import refused

from hfc_design.core.records import UserError
from hfc_design.stability.sectors import sectors_at_centres, true_sectors

# JK04 table 3.
ERROR_CENTRES = (-21.0, -14.0, -7.0, 0.0, 7.0, 14.0, 21.0)
CHANGE_CENTRES = (-4.5, -3.0, -1.5, 0.0, 1.5, 3.0, 4.5)
INFINITY = float("inf")


def meeting(centres):
    """Terms whose edges meet the neighbours' centres."""
    edges = [-INFINITY, *centres, INFINITY]
    return [tuple(edges[k : k + 3]) for k in range(7)]


def searched(error_terms, change_terms, singletons, e_values, de_values):
    """Extreme gains over a grid, 0 (that is, infinity) among them."""
    first, second = [0.0], [0.0]
    for e in e_values:
        start = command(error_terms, change_terms, singletons, e, 0.0)
        if e:
            first.append(start / e)
        for de in de_values:
            if de:
                end = command(error_terms, change_terms, singletons, e, de)
                second.append((end - start) / de)
    return min(first), max(first), min(second), max(second)


def test_table_3_at_its_centres():
    found = sectors_at_centres(ERROR_TERMS, CHANGE_TERMS, rule_singletons("I"))
    assert found.k1 == 32 / 21
    assert found.k1_low == 8 / 7
    assert found.k2 == (16 - 8) / 1.5
    assert found.k2_low == 0.0
    assert confined(found)


def test_table_3_with_its_edges_is_steeper():
    """PM ends at 19 and leaves PL alone: 32 units there. ZR ends at de = 1: PM - PS there."""
    found = true_sectors(ERROR_TERMS, CHANGE_TERMS, rule_singletons("I"))
    assert found.k1 == pytest.approx(32 / 19, rel=1e-14)
    assert found.k2 == pytest.approx((16 - 8) / 1.0, rel=1e-14)
    assert command(ERROR_TERMS, CHANGE_TERMS, rule_singletons("I"), 5.0, 0.0) == 8.0
    assert confined(found)


@pytest.mark.parametrize("base", ["I", "II", "III"])
def test_true_sectors_of_table_3_are_those_of_a_search(base):
    # A grid that holds every edge and centre.
    e_values, de_values = np.arange(-24, 24.5, 0.5), np.arange(-6, 6.125, 0.125)
    own = ERROR_TERMS, CHANGE_TERMS, rule_singletons(base)
    low_1, k1, low_2, k2 = searched(*own, e_values, de_values)
    assert true_sectors(*own) == pytest.approx((low_1, k1, low_2, k2), rel=1e-12, abs=1e-12)


def test_true_sectors_of_random_terms_enclose_a_search_closely():
    random = np.random.default_rng(4)
    for _ in range(3):
        terms = []
        for centres in (ERROR_CENTRES, CHANGE_CENTRES):
            spacing, reach = centres[4], random.uniform(0.35, 1.0, (7, 2))
            own = [
                (c - spacing * left, c, c + spacing * right)
                for c, (left, right) in zip(centres, reach, strict=True)
            ]
            own[0], own[6] = (-INFINITY, *own[0][1:]), (*own[6][:2], INFINITY)
            terms.append(own)
        singletons = np.array(rule_singletons("I")) + random.uniform(-4.0, 4.0, (7, 7))
        singletons[3] = 0.0
        grids = [
            np.concatenate(
                [
                    np.linspace(-1.2, 1.2, 81) * centres[6],
                    [x for t in own for x in t if x and abs(x) < INFINITY],
                ]
            )
            for own, centres in zip(terms, (ERROR_CENTRES, CHANGE_CENTRES), strict=True)
        ]
        coarse = [*ERROR_CENTRES, *grids[0][::8]]
        close = [np.concatenate([g, g - 1e-9, g + 1e-9]) for g in grids]
        wanted = np.array(searched(*terms, singletons, coarse, close[1]))
        wanted[:2] = searched(*terms, singletons, close[0], [])[:2]
        found = np.array(true_sectors(*terms, singletons))
        slack = 1e-6 * abs(wanted).max()
        assert np.all(found[[1, 3]] >= wanted[[1, 3]] - slack)
        assert np.all(found[[0, 2]] <= wanted[[0, 2]] + slack)
        np.testing.assert_allclose(found, wanted, rtol=0.02, atol=0.02)  # the grid is that coarse


def test_a_gap_between_terms_pulls_the_command_to_zero():
    """Where no rule fires the command is 0: u_2 = -u_1 there, against the change of error."""
    narrow = [*CHANGE_TERMS]
    narrow[4] = (1.0, 1.5, 2.0)
    narrow[3] = (-1.0, 0.0, 0.75)
    found = true_sectors(ERROR_TERMS, narrow, rule_singletons("I"))
    assert found.k2_low == pytest.approx(-32 / 0.75, rel=1e-14)
    assert not confined(found)


def test_a_command_that_jumps_at_zero_has_an_infinite_gain():
    singletons = np.array(rule_singletons("I"))
    singletons[3, 3] = 1.0
    found = true_sectors(ERROR_TERMS, CHANGE_TERMS, singletons)
    assert found.k1 == np.inf
    assert found.k1_low == -np.inf
    assert not confined(found)


def test_a_table_against_the_change_of_error_is_not_confined():
    backward = np.array(rule_singletons("II"))[:, ::-1]
    assert not confined(sectors_at_centres(ERROR_TERMS, CHANGE_TERMS, backward))
    assert not confined(true_sectors(ERROR_TERMS, CHANGE_TERMS, backward))


@settings(max_examples=60, deadline=None)
@given(*[st.floats(0.01, 100.0)] * 4)
def test_equation_23_is_equation_14_for_rule_base_1(small, medium, large, spacing):
    changes = [spacing * j for j in range(-3, 4)]
    heights = (-large, -medium, -small, 0.0, small, medium, large)
    found = sectors_at_centres(ERROR_TERMS, meeting(changes), rule_singletons("I", heights))
    closed = k2_of_rule_base_1(small, medium, large, spacing)
    assert closed == pytest.approx(found.k2, rel=1e-9)


def test_equation_7_with_its_cross_term_is_what_the_rules_say():
    random = np.random.default_rng(7)
    error_terms, change_terms = meeting(ERROR_CENTRES), meeting(CHANGE_CENTRES)
    for _ in range(300):
        singletons = random.uniform(-32.0, 32.0, (7, 7))
        e, de = random.uniform(-30.0, 30.0), random.uniform(-6.0, 6.0)
        wanted = command(error_terms, change_terms, singletons, e, de)
        found = bilinear(ERROR_CENTRES, CHANGE_CENTRES, singletons, e, de)
        assert found == pytest.approx(wanted, rel=1e-11, abs=1e-11)


def test_terms_and_tables_that_cannot_be_used():
    good = rule_singletons("I")
    bad = [list(row) for row in good]
    bad[2][5] = float("nan")
    with refused():
        sectors_at_centres(ERROR_TERMS, CHANGE_TERMS, bad)
    with refused():
        sectors_at_centres(ERROR_TERMS, CHANGE_TERMS[::-1], good)
    with refused():
        sectors_at_centres(meeting((-3, -2, -1, 1, 2, 3, 4)), CHANGE_TERMS, good)
    with refused() as found:
        true_sectors((ERROR_TERMS[0], (-14.0, -14.0, -9.0), *ERROR_TERMS[2:]), CHANGE_TERMS, good)
    assert found.where == "term 2 of the error"


numbers = st.floats() | st.floats(-40.0, 40.0) | st.integers(-3, 3).map(float)
sevens = st.lists(numbers, min_size=7, max_size=7)
ascending = st.lists(st.floats(1e-6, 1e3), min_size=3, max_size=3, unique=True).map(
    lambda x: sorted([0.0, *x, *(-v for v in x)])
)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(sevens, min_size=7, max_size=7),
    ascending | sevens,
    ascending,
    st.lists(numbers, min_size=14, max_size=14),
)
def test_any_numbers_give_sectors_or_one_line(singletons, errors, changes, edges):
    odd = [(edges[k], errors[k], edges[k + 7]) for k in range(7)]
    good = np.nan_to_num(np.clip(singletons, -1e3, 1e3))
    for call in (
        lambda: sectors_at_centres(meeting(errors), meeting(changes), singletons),
        lambda: sectors_at_centres(meeting(errors), meeting(changes), good),
        lambda: true_sectors(odd, meeting(changes), good),
        lambda: true_sectors(meeting(errors), meeting(changes), singletons),
        lambda: true_sectors(meeting(errors), meeting(changes), good),
    ):
        try:
            found = call()
        except UserError as error:
            assert "\n" not in str(error)
        else:
            assert found.k1_low <= found.k1
            assert found.k2_low <= found.k2


def test_no_last_bit_makes_a_command_jump():
    """Where no change is, two terms rule: u(e, de) - u(e, 0) is 0 there, but for rounding."""
    terms = [(-INFINITY, -4.0, 3.1), (-7.0, -1.3, 5.2), (-2.7, 1.9, 8.0), (-1.1, 6.0, INFINITY)]
    rows = np.array([[-9.1, -4.2, 2.3, 7.7], [-8.3, -0.7, 3.3, 9.4]])
    rows = np.concatenate([rows - 1.7, rows + 2.9])
    second = searched(terms, terms, rows, [0.3], np.linspace(-20.0, 20.0, 401))[3]
    found = []
    for numbers in shaken(*rows.ravel()):
        found.append(true_sectors(terms, terms, np.reshape(numbers, (4, 4)).tolist()))
        assert np.isfinite(found[-1][2:]).all()
        np.testing.assert_allclose(found[-1][2:], found[0][2:], rtol=1e-6)
    assert found[0].k2 >= second
