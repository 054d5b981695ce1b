"""Labels and numbers of a rule table, which cannot contradict one another, and its names."""

import json

import made_up
import numpy as np
import pytest
from wording import refused

from hfc_design.files.design import design_json, parse_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import individuals
from hfc_design.stability.sectors import true_sectors


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


@pytest.mark.parametrize(("rows", "columns"), [(3, 5), (7, 3), (11, 11)])
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
