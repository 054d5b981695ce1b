"""Resonators: by SciPy's filter, on a linear plant by its transfer function, at a limit."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.runs.individuals import genome_of

KINDS = ("pid+ff", "lqr", "lqi")


@pytest.mark.parametrize("kind", KINDS)
def test_the_start_holds_against_a_load_that_is_told(kind):
    """On the C-axis, friction and all: under a load of 5 rad/s a tenth of the error is left."""
    load = {"sines": [{"amplitude": 1.0, "frequency_rad_s": 5.0}]}
    late = {}
    for frequencies in ((), (5.0,)):
        own = {"kind": kind, "load_frequencies_rad_s": frequencies}
        changes = {"load": load, "simulation.duration_s": 10.0, "controller": own}
        start = api.load_scenario("c-axis-ramp", changes)
        made = genome_of(start)
        gains = {k: x for k, x in made.record(made.empty()).items() if k != "kind"}
        found = api.evaluate(api.with_gains(start, kind, gains), start)
        late[frequencies] = np.std(found.axes[0].motion.error[8700:])
    assert 0.0 < late[(5.0,)] < 0.1 * late[()]
