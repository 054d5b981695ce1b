"""The search of a feed drive's fuzzy controllers: its genome, and what comes out of it."""

import json

import made_up
import numpy as np
import pytest
from feed_genomes import CIRCLE, bred, genome
from jk04 import confined
from wording import refused

from hfc_design.controllers.aflc.record import AflcDesign
from hfc_design.controllers.genome import taken
from hfc_design.files.design import design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import individuals
from hfc_design.stability.sectors import true_sectors
from hfc_design.stability.stable_range import stable_range

KINDS = ("flc", "aflc")


def test_terms_that_overlap_wholly_are_terms_of_a_design():
    """Their overlap is the distance of two centres, and never more by rounding."""
    own = genome("aflc", "controller.symmetric=false")
    found = bred(own, count=200)
    found.joints[..., 1:] = 0.0, 1.0
    for k in range(200):
        record = type(own.start).model_validate(own.record(taken(found, slice(k, k + 1))))
        least = record.adaptation.smallest_overlap
        centres = np.array([term.centre for term in record.error_terms])
        assert least.error == pytest.approx(np.diff(centres).min(), rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_every_table_lies_in_the_stable_range_and_has_no_gap(kind):
    own = genome(kind)
    drive = stable_range(40.0, 0.055, 0.01)
    found = bred(own, count=12)
    assert np.ptp(found.singletons, axis=0).max() > 10  # they do differ
    for k in range(len(found.tree)):
        individual = taken(found, slice(k, k + 1))
        record = type(own.start).model_validate(own.record(individual))  # refuses gaps
        sectors = true_sectors(*record.table()[:3])
        assert drive.contains(max(sectors.k1, 1e-9), sectors.k2)
        assert confined(sectors)
        assert abs(np.array(record.rules.centroids)).max() <= 127
        if isinstance(record, AflcDesign):
            limits = record.adaptation.stable_range
            assert drive.contains(limits.k1_max, limits.k2_max)
            assert sectors.k1 <= limits.k1_max * (1 + 1e-8)  # the oracle rounds edges
            assert sectors.k2 <= limits.k2_max * (1 + 1e-8)  # the oracle rounds edges


def test_symmetric_tables_treat_both_directions_alike():
    found = bred(genome("aflc"))
    np.testing.assert_allclose(found.singletons, -found.singletons[:, ::-1, ::-1], atol=1e-12)
    lopsided = bred(genome("aflc", "controller.symmetric=false"))
    assert abs(lopsided.singletons + lopsided.singletons[:, ::-1, ::-1]).max() > 1.0


@pytest.mark.parametrize(
    ("scenario", "key", "value"),
    [
        ("c-axis-ramp", "controller", "{kind='flc'}"),
        (CIRCLE, "controller.start", "jee-koren-2004-pid"),
        (CIRCLE, "simulation.sample_time_s", "0.005"),
        (CIRCLE, "search.preset", "lin-lee-1999"),
    ],
)
def test_searches_that_cannot_be(scenario, key, value):
    with refused() as found:
        load_scenario(scenario, [f"{key}={value}"])
    assert found.where == scenario


def genome_of(design, folder):
    (folder / "start.json").write_text(design_json(design))
    start = ["controller.kind=flc", f"controller.start={folder / 'start.json'}"]
    return individuals.genome_of(load_scenario("feed-drive-circle", start))


def centred(rows, columns):
    """A table of another program, with middle terms on 0."""
    data = json.loads(design_json(made_up.named(3, rows, columns)))
    heights = 4.0 * np.add.outer(np.arange(rows) - rows // 2, np.arange(columns) - columns // 2)
    data["controller"]["rules"] = {"centroids": heights.tolist()}
    for key in ("error_terms", "error_change_terms"):
        terms = data["controller"][key]
        for k, term in enumerate(terms):
            centre = float(k - len(terms) // 2)
            ends = {"left": centre - 1.0 if k else None}
            ends["right"] = centre + 1.0 if k + 1 < len(terms) else None
            term |= {"centre": centre, **ends}
    return parse_design(json.dumps(data), "start.json")


@pytest.mark.parametrize(("rows", "columns"), [(3, 5), (11, 11)])
def test_a_search_varies_tables_of_any_odd_size_within_the_stable_range(rows, columns, tmp_path):
    start = centred(rows, columns)
    own, random = genome_of(start, tmp_path), np.random.default_rng(1)
    found = own.fresh(np.zeros(8, int), random)
    found = own.mutated(found, np.full(8, 0.3), random)
    found = own.blended(found, found, np.full(8, 0.5))
    for k in range(8):
        one = type(found)(*(part[k : k + 1] for part in found))
        record = type(start.controller).model_validate(own.record(one))
        assert record.rules.shape() == (rows, columns)
        assert record.names == start.controller.names
        labels = [term.label for term in record.error_change_terms]
        assert labels == [term.label for term in start.controller.error_change_terms]
        sectors = true_sectors(*record.table()[:3])
        assert own.stable.contains(max(sectors.k1, 1e-3), sectors.k2)  # of 0 there is no range
        assert min(sectors.k1_low, sectors.k2_low) >= -1e-9


def test_a_search_needs_a_middle_term(tmp_path):
    with refused() as found:
        genome_of(made_up.named(2, 2, 11), tmp_path)
    assert "error_terms" in found.refusal


def test_a_start_inside_the_range_is_the_first_individual():
    start = load_design("jee-koren-2004-aflc").controller
    # At K = 10 the range is four times as wide and takes the table as it is.
    own = genome("aflc", "plant.parameters.gain=10.0", "reference.feed_mm_min=100.0")
    record = own.record(own.empty())
    np.testing.assert_allclose(record["rules"]["centroids"], start.rules.centroids, atol=1e-12)
    assert [tuple(row) for row in record["rules"]["labels"]] == list(start.rules.labels)
    for key in ("error_terms", "error_change_terms"):
        for mine, theirs in zip(record[key], getattr(start, key), strict=True):
            assert mine["centre"] == pytest.approx(theirs.centre, abs=1e-12)
            assert (mine["left"] is None) == (theirs.left is None)
