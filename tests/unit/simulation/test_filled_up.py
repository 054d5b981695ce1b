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


def test_few_records_are_filled_up_so_far_that_motions_of_all_usual_lengths_are_one():
    """By hand: 16,384 samples of one individual are 1 MB for each 8 quantities, of four 4,096."""
    assert {filled_up_steps(steps, 1) for steps in (1, 500, 6000, 16_384)} == {16_384}
    assert {filled_up_steps(steps, 4) for steps in (1, 500, 4096)} == {4096}
    for steps, recorded in ((16_385, 1), (6000, 4), (3000, 1000)):
        assert filled_up_steps(steps, recorded) == filled_up_steps(steps)
