"""A network off line and on line: taught, simulated, searched, refused, and one that diverges."""

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
