"""How many samples motions are filled up to, so that few programs do for all lengths."""

import numpy as np

from hfc_design.simulation.compiled import FEWEST_STEPS, filled_up_steps


def test_up_to_a_quarter_more_samples_make_four_lengths_of_an_octave():
    steps = np.arange(1, 16 * FEWEST_STEPS + 1)
    filled = np.array([filled_up_steps(int(one)) for one in steps])
    assert (filled >= steps).all()
    assert (filled - steps <= np.maximum(steps // 4, FEWEST_STEPS - 1)).all()
    for octave in (4, 8):  # from so many of the fewest steps to twice as many
        inside = (steps > octave * FEWEST_STEPS) & (steps <= 2 * octave * FEWEST_STEPS)
        assert len({*filled[inside].tolist()}) == 4
