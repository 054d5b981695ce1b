"""The adaptive controllers: the papers' tables and examples, plain transcriptions, the bounds."""

import feed_oracle
import numpy as np
import pytest
from jk04 import CHANGE_TERMS, ERROR_TERMS, rule_singletons

from hfc_design.controllers.aflc import law as aflc
from hfc_design.controllers.aflc.adaptation import (
    PERFORMANCE,
    blamed_aflc,
    blamed_soflc,
)
from hfc_design.controllers.aflc.law import AdaptiveGains, Judge, Rates
from hfc_design.controllers.flc.law import FlcGains, infer
from hfc_design.controllers.neighbours import Partition, memberships, spread
from hfc_design.core.numbers import SCALARS
from hfc_design.core.records import ZR
from hfc_design.stability.sectors import Curve, Rectangle

PS, PM, PL = 4, 5, 6
WIDE = Rectangle(1e6, 1e6)
#: Below JK04 fig. 4 for the printed drive.
FIG_4 = (
    (2.2, 9.3),
    (2.6, 9.0),
    (3.0, 8.5),
    (3.5, 7.6),
    (4.0, 6.7),
    (5.0, 5.0),
    (6.0, 3.5),
    (7.2, 2),
)


def gains_of(rates=(0.5, 0.125, 1.0), sectors=WIDE, base="I", overlaps=None):
    table = FlcGains(ERROR_TERMS, CHANGE_TERMS, rule_singletons(base), 0.0)
    return AdaptiveGains(table, Rates(*rates, *(overlaps or rates[:2])), sectors)


def sampled(gains, blamed, memory, error, narrows_zero=False):
    """The command of one sample, what to remember, and what it is made of."""
    law = aflc.aflc(0.01, judge=Judge(blamed, narrows_zero))
    return law.sample(SCALARS, law, gains, memory, {"error": error})


def stepped(gains, blamed, errors, narrows_zero=False):
    """Command, memory after each sample of errors."""
    memory = aflc.aflc(0.01).begun(SCALARS, 0.0, gains)
    for error in errors:
        command, memory, _ = sampled(gains, blamed, memory, error, narrows_zero)
        yield command, memory


def after(errors, blamed=blamed_aflc, gains=None, narrows_zero=False):
    """Error terms, change terms and singletons after the last of errors."""
    gains = gains or gains_of()
    *_, (_, memory) = stepped(gains, blamed, errors, narrows_zero)
    return table_of(memory.base(gains))


def table_of(base):
    """Triangles of the error and of its change, and singletons."""
    return base.error.triangles(), base.change.triangles(), base.singletons


def degrees_in(triangles, value):
    """The degrees of a value in all terms."""
    return spread(memberships(SCALARS, Partition.of(triangles), value), len(triangles))


def test_performance_indices_are_table_2():
    np.testing.assert_array_equal(PERFORMANCE, feed_oracle.INDEX)


def test_example_1_of_jk04():
    """e(k-1) = PS, de = PS alone; then e(k) = 3 is more ZR (0.4) than PS (0.2): p = 0."""
    before = after([7.0 - 1.5, 7.0])
    fired = degrees_in(before[0], 7.0), degrees_in(before[1], 1.5)
    assert [d.count(0.0) for d in fired] == [6, 6]
    assert after([5.5, 7.0, 3.0]) == before


def test_example_2_of_jk04():
    """e(k-1) = 10 in PS and PM, de = 0; e(k) = 18 is more PL than PM: p = -2 and -1."""
    started = gains_of()._replace(rates=Rates(0.0, 0.0, 0.0, 0.0, 0.0))
    *_, (action, memory) = stepped(started, blamed_aflc, [10.0, 10.0])
    assert action == pytest.approx((0.4 * 8 + 0.2 * 16) / 0.6)
    _, memory, _ = sampled(gains_of(), blamed_aflc, memory, 18.0)
    error_terms, change_terms, table = table_of(memory.base(gains_of()))
    assert error_terms[PS] == (2.0 + 1.0, 7.0, 12.0 - 1.0)  # rule (a): narrower by two steps
    assert error_terms[PM] == (9.0 - 0.5, 14.0, 19.0 + 0.5)  # rule (b): wider by one
    assert change_terms[ZR] == (-1.0 + 0.125, 0.0, 1.0 - 0.125)  # two steps less one
    assert table[PS][ZR] == 8.0 + 2.0
    assert table[PM][ZR] == 16.0
    changed = np.array(table) - np.array(rule_singletons("I"))
    assert np.count_nonzero(changed) == 1
    assert [t for k, t in enumerate(error_terms) if k not in (PS, PM)] == [
        t for k, t in enumerate(ERROR_TERMS) if k not in (PS, PM)
    ]


CASES = [(e, p, c) for e in (2.0, -2.0) for p in (2, 1, -1, -2) for c in (-1.0, 0.0, 1.0)]


@pytest.mark.parametrize(("e", "p", "excess"), CASES)
def test_who_is_to_blame(e, p, excess):
    jk04 = feed_oracle.verdict_jk04(e, p, excess, 0.0)[0]
    jk95 = feed_oracle.verdict_jk95(e, p, excess, 0.0)[0]
    assert blamed_aflc(SCALARS, e, p, excess) is jk04
    assert blamed_soflc(SCALARS, e, p, excess) is jk95
    # The papers differ in the second case, and at equality in the first and the fourth.
    assert (jk04 != jk95) is ((e > 0 and p < 0) or (excess == 0.0 and e * p > 0))


def test_soflc_steps_of_jk95():
    gains = gains_of((0.5, 0.2, 1.0), None)
    _, memory = list(stepped(gains, blamed_soflc, [10.0]))[-1]
    memory = memory._replace(change=0.0, action=32.0 / 3.0)
    _, memory, _ = sampled(gains, blamed_soflc, memory, 18.0)
    error_terms, change_terms, _ = table_of(memory.base(gains))
    np.testing.assert_allclose(error_terms[PS], (2.0 - 1.0, 7.0, 12.0 + 1.0))  # |p| = 2
    np.testing.assert_allclose(error_terms[PM], (9.0 + 0.5, 14.0, 19.0 - 0.5))  # |p| = 1
    np.testing.assert_allclose(change_terms[ZR], (-1.0 - 0.2, 0.0, 1.0 + 0.2))


@pytest.mark.parametrize(
    ("paper", "rates", "sectors", "base", "overlaps", "narrows_zero"),
    [
        (2004, (0.5, 0.125, 1.0), (4.5, 5.9), "I", (3.0, 0.5), False),
        (2004, (0.5, 0.125, 1.0), (4.5, 5.9), "I", (3.0, 0.5), True),
        (2004, (0.5, 0.125, 1.0), (7.2, 9.0, FIG_4), "I", (3.0, 0.5), False),
        (2004, (0.5, 0.125, 1.0), (2.0, 3.0), "III", (7.0, 1.5), False),
        (1995, (0.5, 0.2, 1.0), None, "I", None, False),
        (1995, (0.5, 0.2, 1.0), (4.0, 6.79), "I", (5.0, 1.0), True),
    ],
)
def test_equals_a_plain_transcription(paper, rates, sectors, base, overlaps, narrows_zero):
    of_2004 = (blamed_aflc, feed_oracle.verdict_jk04)
    blamed, verdict = of_2004 if paper == 2004 else (blamed_soflc, feed_oracle.verdict_jk95)
    own = sectors and (Curve if len(sectors) == 3 else Rectangle)(*sectors)
    gains = gains_of(rates, own, base, overlaps)
    plain = feed_oracle.Adaptive(
        ERROR_TERMS,
        CHANGE_TERMS,
        rule_singletons(base),
        rates,
        verdict,
        sectors,
        overlaps,
        narrows_zero,
    )
    errors = feed_oracle.errors(800, 1)
    commands, memories = zip(*stepped(gains, blamed, errors, narrows_zero), strict=True)
    expected = [plain.step(error) for error in errors]
    np.testing.assert_allclose(commands, expected, rtol=1e-9, atol=1e-9)
    error_terms, change_terms, table = table_of(memories[-1].base(gains))
    np.testing.assert_allclose(error_terms, plain.a, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(change_terms, plain.b, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(table, plain.c, rtol=1e-9, atol=1e-9)
    assert np.abs(np.array(table) - rule_singletons(base)).max() > 3.0  # it did learn


def no_gap(terms, overlap):
    for k in range(6):
        (_, low, right), (left, high, _) = terms[k], terms[k + 1]
        assert right - left >= overlap - 1e-12
        assert low <= left < high
        assert low < right <= high


@pytest.mark.parametrize(("base", "seed"), [("I", 0), ("III", 0)])
def test_driven_hard_it_stays_inside(base, seed):
    k1, k2 = 1.9, 4.0
    gains = gains_of((0.5, 0.125, 4.0), Rectangle(k1, k2), base)
    sign = np.sign(rule_singletons(base))
    grid = np.linspace(-30.0, 30.0, 241)
    fine = np.linspace(-6.0, 6.0, 193)
    for k, (_, memory) in enumerate(
        stepped(gains, blamed_aflc, feed_oracle.errors(1000, seed + 10))
    ):
        if k % 100:
            continue
        error_terms, change_terms, table = table_of(memory.base(gains))
        no_gap(error_terms, 0.5)
        no_gap(change_terms, 0.125)
        assert table[ZR] == list(rule_singletons(base)[ZR])
        rows = np.array([degrees_in(error_terms, e) for e in grid])
        columns = np.array([degrees_in(change_terms, d) for d in fine])
        rows /= rows.sum(1, keepdims=True)
        columns /= columns.sum(1, keepdims=True)
        u = rows @ np.array(table) @ columns.T
        u1 = rows @ np.array(table)[:, ZR]
        assert (u1 * grid >= -1e-9).all()
        assert (u1 * grid <= k1 * grid**2 + 1e-9).all()
        if base == "I":  # the row e = ZR of the others is their own and steeper
            u2 = u - u1[:, None]
            assert (u2 * fine >= -1e-9).all()
            assert (u2 * fine <= k2 * fine**2 + 1e-9).all()
            assert (np.array(table) * sign >= -1e-12).all()
        assert infer(SCALARS, rows[5], columns[7], table) == pytest.approx(u[5, 7], abs=1e-12)


def test_an_error_that_leaves_zr_narrows_its_rules():
    """At 1 the rule (ZR, ZR) alone fires; 10 is more PS (0.4) than PM (0.2): a step, no more."""
    errors = [1.0, 1.0, 10.0]
    error_terms, change_terms, table = after(errors, narrows_zero=True)
    assert error_terms[ZR] == (-5.0 + 0.5, 0.0, 5.0 - 0.5)
    assert change_terms[ZR] == (-1.0 + 0.125, 0.0, 1.0 - 0.125)
    assert np.array_equal(table, rule_singletons("I"))
    others = [k for k in range(7) if k != ZR]
    assert [error_terms[k] for k in others] == [ERROR_TERMS[k] for k in others]
    assert [change_terms[k] for k in others] == [CHANGE_TERMS[k] for k in others]
    assert after(errors) == after([0.0])  # Table 2 alone does not consider ZR
    assert after([0.0, 0.0, 10.0], narrows_zero=True) == after([0.0])  # 0 judges nothing
    assert after([1.0, 1.0, 3.0], narrows_zero=True) == after([0.0])  # more ZR (0.4) than PS (0.2)


def test_an_error_within_the_dead_zone_is_none():
    flc = gains_of().flc._replace(dead_zone=1.0, k_i=8.0)
    gains = gains_of()._replace(flc=flc)
    *_, (_, dead) = stepped(gains, blamed_aflc, [7.0, 1.0, -1.0, -7.0])
    *_, (_, plain) = stepped(gains_of()._replace(flc=flc), blamed_aflc, [7.0, 0.0, 0.0, -7.0])
    assert dead == plain
    assert dead.integral == pytest.approx(0.0)
