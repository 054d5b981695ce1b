"""A network off line and on line: taught, simulated, searched, refused, and one that diverges."""

from made_up import network

import hfc_design.api as hfc
from hfc_design.controllers.neural.record import drawn

SHORT = {"simulation.duration_s": 4.0}


def test_a_search_varies_the_numbers_beside_the_weights():
    settings = {"kind": "neural", "hidden": 4, "ranges": {"error_unit": [0.5, 5.0]}}
    changes = {**SHORT, "search.generations": 2, "search.population": 16, "controller": settings}
    result = hfc.design(hfc.load_scenario("feed-drive-circle", changes))
    own = result.design.controller
    assert own.weights == drawn(4, 0)
    assert 0.5 <= own.error_unit <= 5.0
    assert 1e-6 <= own.rate <= 0.1


def test_one_that_diverges_is_counted():
    """On line beyond all numbers: a result, not an error."""
    design = network(0, 4, rate=1e6, error_unit=1e-160, slope=1.0)
    found = hfc.evaluate(design, hfc.load_scenario("feed-drive-circle", SHORT))
    assert found.diverged
