"""X-Y machines in the population simulator: the published figures, contour fitness, bad input."""

import numpy as np
import pytest

from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.simulation.evaluating import evaluate


@pytest.fixture(scope="module")
def flc():
    design = load_design("jee-koren-2004-flc")
    return evaluate(design, own_scenario(design, "jee-koren-2004-flc"))


def test_commands_and_readings_are_whole_numbers(flc):
    for axis in flc.axes:
        command = axis.motion.command
        assert (command == np.round(command)).all()
        assert (axis.reference == np.round(axis.reference)).all()
        assert abs(command).max() <= 32  # the table's largest singleton
