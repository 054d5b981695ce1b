"""The fuzzy controller of a feed drive: by hand, the bilinear form, the forms, compensation."""

import json

import made_up
import numpy as np
import pytest
from jk04 import CHANGE_TERMS, ERROR_TERMS, RULE_BASES, rule_labels, rule_singletons
from shaken import shaken
from wording import refused

from hfc_design.controllers import neighbours
from hfc_design.controllers.flc import law as flc
from hfc_design.controllers.flc.law import (
    Compensation,
    FlcGains,
    compensate,
    infer,
)
from hfc_design.controllers.flc.rules import LABELS, nearest_labels
from hfc_design.controllers.neighbours import Partition
from hfc_design.core.numbers import SCALARS
from hfc_design.files.design import design_json, named_design, parse_design

INF = float("inf")


def memberships(triangles, value):
    """The degrees of a value in all terms."""
    degrees = neighbours.memberships(SCALARS, Partition.of(triangles), value)
    return neighbours.spread(degrees, len(triangles))


X_AXIS = Compensation((0.05, -1.16, 6.54), (-0.04, -1.0, -6.43), 12.0, (6.54, -6.43), 2.0, 0.01)


def gains_of(base="I", k_i=0.0, compensation=None):
    return FlcGains(ERROR_TERMS, CHANGE_TERMS, rule_singletons(base), k_i, compensation)


def commands(errors, form="PD", gains=None, sample_time=0.01):
    law = flc.flc(form, sample_time)
    memory = law.initial_memory(0.0)
    for error in errors:
        command, memory, _ = law.sample(SCALARS, law, gains or gains_of(), memory, {"error": error})
        yield command


@pytest.mark.parametrize(
    ("e", "degrees"),
    [
        (0.0, {"ZR": 1.0}),
        (3.0, {"ZR": 0.4, "PS": 0.2}),
        (5.0, {"PS": 0.6}),  # the right edge of ZR no longer belongs to it
        (-10.0, {"NM": 0.2, "NS": 0.4}),
        (18.0, {"PM": 0.2, "PL": 0.4}),
        (1000.0, {"PL": 1.0}),
        (-1000.0, {"NL": 1.0}),
    ],
)
def test_degrees_by_hand(e, degrees):
    found = dict(zip(LABELS, memberships(ERROR_TERMS, e), strict=True))
    assert found == pytest.approx(dict.fromkeys(LABELS, 0.0) | degrees)


def test_command_by_hand():
    """e: 0 -> 3 -> 4. First de = 3, PM alone; then de = 1, PS alone."""
    first, second = commands([3.0, 4.0])
    assert first == pytest.approx((0.4 * 0 + 0.2 * 16) / 0.6)  # ZR/PM -> ZR, PS/PM -> PM
    # At e = 4: ZR 0.2, PS 0.4; de = 1: ZR 0, PS 0.5. PS/PS -> PM = 16.
    assert second == pytest.approx(0.4 * 0.5 * 16 / (0.6 * 0.5))


def test_where_no_rule_fires_there_is_no_action():
    gap = [(-INF, -21.0, -16.0), *ERROR_TERMS[1:3], (-1.0, 0.0, 1.0), *ERROR_TERMS[4:]]
    degrees = memberships(gap, 1.5)
    assert degrees == [0.0] * 7
    assert infer(SCALARS, degrees, memberships(CHANGE_TERMS, 0.0), [[9.0] * 7] * 7) == 0.0


def evenly(distance):
    """Terms whose edges lie on the neighbours' centres."""
    centres = [distance * k for k in range(-3, 4)]
    return [
        (c - distance if k else -INF, c, c + distance if k < 6 else INF)
        for k, c in enumerate(centres)
    ]


@pytest.mark.parametrize("seed", range(3))
def test_evenly_spaced_terms_are_bilinear(seed):
    """JK04 eq. 7 with the cross term that it lacks, against the rules one by one."""
    random = np.random.default_rng(seed)
    alpha, beta = 7.0, 1.5
    table = random.uniform(-32, 32, (7, 7))
    missing = 0.0
    for e, de in random.uniform((-21, -4.5), (21, 4.5), (200, 2)):
        i, j = int(np.floor(e / alpha)) + 3, int(np.floor(de / beta)) + 3
        x, y = e / alpha - (i - 3), de / beta - (j - 3)
        u, right, up = table[i, j], table[i + 1, j], table[i, j + 1]
        printed = u + x * (right - u) + y * (up - u)
        cross = (table[i + 1, j + 1] - right - up + u) * x * y
        degrees = memberships(evenly(alpha), e), memberships(evenly(beta), de)
        assert infer(SCALARS, *degrees, table) == pytest.approx(printed + cross)
        missing = max(missing, abs(cross))
    assert missing > 1.0


def test_rule_bases_are_skew_symmetric():
    """JK04 Appendix A; a slip in typing a table would show here."""
    for base in RULE_BASES:
        table = np.array(rule_singletons(base))
        np.testing.assert_array_equal(table, -table[::-1, ::-1])
    assert rule_labels("I")[4] == ("ZR", "PS", "PS", "PS", "PM", "PM", "PL")
    linear = np.clip(np.add.outer(range(-3, 4), range(-3, 4)), -3, 3)  # JK04 Table 5
    labels = [[LABELS[k + 3] for k in row] for row in linear]
    assert labels == [list(row) for row in rule_labels("II")]
    for base in ("II", "III"):  # the same proportional part in all three
        assert [row[3] for row in rule_labels(base)] == [row[3] for row in rule_labels("I")]


def test_forms_of_jk95():
    errors = [7.0, 7.0, 14.0, 0.0]
    u_p = [8.0, 8.0, 16.0, 0.0]  # the column de = ZR
    u_pd = [32.0, 8.0, 32.0, 0.0]  # de = PL, ZR, PL, NL
    assert list(commands(errors, "P")) == u_p
    assert list(commands(errors, "PD")) == u_pd
    assert list(commands(errors, "PI")) == np.cumsum(u_pd).tolist()
    integral = 8.0 * 0.01 * np.cumsum(errors)  # K_I = 8 per second
    found = list(commands(errors, "PD", gains_of(k_i=8.0)))
    np.testing.assert_allclose(found, u_pd + integral)


@pytest.mark.parametrize(
    ("v_mm_s", "error", "u_d"),
    [
        (4.0, 0.0, 0.05 * 16 - 1.16 * 4 + 6.54),
        (-4.0, 9.0, -0.04 * 16 + 1.0 * 4 - 6.43),
        (11.99, 0.0, 0.05 * 11.99**2 - 1.16 * 11.99 + 6.54),
        (12.0, 5.0, 0.0),
        (-12.5, 5.0, 0.0),
        (0.0, 2.0, 6.54),
        (0.0, -2.0, -6.43),
        (0.0, 1.0, 0.0),
        (0.0, -1.0, 0.0),
    ],
)
def test_low_velocity_compensation(v_mm_s, error, u_d):
    """JK04 eq. 28 (X axis) and eq. 30; velocity in BLU/s, 0.01 mm each."""
    assert compensate(SCALARS, X_AXIS, 100.0 * v_mm_s, error) == pytest.approx(u_d)


def test_compensation_of_jk95_at_rest():
    """U_c = F_ds where |E| > 2 BLU: the third whole BLU."""
    law = X_AXIS._replace(breakaway=(9.0, -9.0), smallest_error=3.0)
    found = [compensate(SCALARS, law, 0.0, e) for e in (-3.0, -2.0, 0.0, 2.0, 3.0)]
    assert found == [-9.0, 0.0, 0.0, 0.0, 9.0]


FLC = "jee-koren-2004-flc"


def parsed(design, **rules):
    """The design after other rules were written into its file."""
    data = json.loads(design_json(design))
    data["controller"]["rules"] |= rules
    for key in [key for key, value in rules.items() if value is None]:
        del data["controller"]["rules"][key]
    return parse_design(json.dumps(data), "mine.json").controller.rules


def test_labels_may_be_left_out_and_follow_from_the_numbers():
    """JK04 Table 3: the heights of the seven labels are 1, 1/2, 1/4 of the largest."""
    own = named_design(FLC)
    assert parsed(own, labels=None) == own.controller.rules
    found = parsed(made_up.fuzzy("flc", 1, 2, 3), labels=None, centroids=[[-9, 0, 1], [4, 2.6, 9]])
    assert found.labels == (("NL", "ZR", "ZR"), ("PM", "PS", "PL"))


def test_a_larger_label_cannot_have_a_smaller_number():
    own = named_design(FLC)
    table = [list(row) for row in own.controller.rules.centroids]
    table[1][2] = 9.0  # an NM above the PS of 8
    with refused() as found:
        parsed(own, centroids=table)
    assert "controller.rules.labels.1.2 = 'NM' is 9" in found.refusal
    assert parsed(own, centroids=table, labels=None).labels[1][2] == "PS"
    table[1][2] = -9.0  # between its neighbours
    assert parsed(own, centroids=table).labels == own.controller.rules.labels


def test_a_named_singleton_is_one_number():
    own = made_up.named(2, 2, 3)
    rules = own.controller.rules
    assert parsed(own, centroids=None) == rules
    table = [list(row) for row in rules.centroids]
    table[1][0] += 1.0
    with refused() as found:
        parsed(own, centroids=table)
    assert "rules.centroids.1.0 = " in found.refusal
    with refused() as found:
        parsed(own, labels=[["PL"] * 3] * 2)
    assert "rules.labels.0.0 = 'PL'" in found.refusal


@pytest.mark.parametrize(
    "change",
    [
        {"rules": {"centroids": [[0.0] * 3] * 4}},
        {"names": {"error": "a", "output": "A"}},
        {"names": {"error": "e; DROP"}},
    ],
)
def test_shapes_and_names_that_do_not_fit(change):
    data = json.loads(design_json(made_up.fuzzy("flc", 1, 5, 3)))
    data["controller"] |= change
    with refused() as found:
        parse_design(json.dumps(data), "mine.json")
    assert f"controller.{next(iter(change))}" in found.refusal


def test_a_number_between_two_labels_has_the_lower_one_of_both():
    """12 of 32 is as near to 8 as to 16, but for its last bits."""
    for largest, between in shaken(32.0, 12.0):
        assert nearest_labels([[-largest, -between, between, largest]]) == [
            ["NL", "NM", "PS", "PL"]
        ]
