"""C keeps the limits of a command and of its rate as the runtime does."""

import numpy as np
import pytest
from c_program import together
from held_back import FORMS, by_hand, free, limited, samples, slow, stepped

from hfc_design.files.design import Limits


def commanded(own, folder, *flags, real=np.float64, within=None):
    """Of each of the designs what C commands, and the signals that it has to be of."""
    run = together(own, folder, *flags, within=within)
    signals = {case: samples(design) for case, design in own.items()}
    rows = {case: np.stack([*told.values()], axis=1) for case, told in signals.items()}
    return {case: (run(case, rows[case], real), signals[case]) for case in own}


def test_the_runtime_and_c_keep_a_limit_alike(tmp_path):
    own = {case: limited(name, **changes) for case, (name, changes) in FORMS.items()}
    for case, (found, signals) in commanded(own, tmp_path).items():
        limit, expected = own[case].limits.command, stepped(own[case], signals)
        # It does hold back, and never lets more pass; a sum alone stops within a step of it.
        assert 0.95 * limit < np.abs(expected).max() <= limit, case
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * limit, err_msg=case)
        assert np.abs(found).max() <= limit, case


@pytest.mark.parametrize("times", [None, 3.0])
def test_a_limit_of_the_caller_is_one_of_the_design(times, tmp_path):
    """Bit for bit, of designs without a limit and of those with a larger one."""
    own = {case: limited(name, **changes) for case, (name, changes) in FORMS.items()}
    within = {case: design.limits.command for case, design in own.items()}
    others = {
        case: design.model_copy(update={"limits": Limits(command=times and times * within[case])})
        for case, design in own.items()
    }
    expected = commanded(own, tmp_path / "own")
    for case, (found, _) in commanded(others, tmp_path / "caller", within=within).items():
        np.testing.assert_array_equal(found, expected[case][0], err_msg=case)


def test_the_runtime_and_c_keep_a_rate_alike(tmp_path):
    own = {case: slow(name, **changes) for case, (name, changes) in FORMS.items()}
    pids = {case: design for case, design in own.items() if "pid" in case}
    single = commanded(pids, tmp_path / "float", "-DHFC_FLOAT", real=np.float32)
    for case, (found, signals) in commanded(own, tmp_path / "double").items():
        limits, expected = own[case].limits, stepped(own[case], signals)
        change = limits.command_rate * own[case].controller.sample_time_s
        free_ones = stepped(free(own[case]), signals)
        np.testing.assert_array_equal(expected, by_hand(free_ones, change), err_msg=case)
        moves = np.abs(np.diff(expected, prepend=0.0))
        assert np.isclose(moves, change).sum() > 20, case  # it does hold back
        atol = 1e-12 * limits.command
        np.testing.assert_allclose(found, expected, rtol=0, atol=atol, err_msg=case)
        if case in pids:
            told, _ = single[case]
            np.testing.assert_allclose(told, expected, rtol=0, atol=1e-4 * limits.command)
            assert np.abs(np.diff(told, prepend=0.0)).max() <= change * (1.0 + 1e-5)
