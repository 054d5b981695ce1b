"""The exported function in Octave: what the runtime commands, on random designs of every kind.

Octave has functions of its own for exp and tanh: measured are 4e-16 of the largest command.
"""

import numpy as np
import pytest
from random_designs import MADE, design_of, of_the_runtime, samples_of

from hfc_design.formats import code
from hfc_design.formats.scripts import function


@pytest.mark.parametrize("kind", MADE)
def test_commands_are_those_of_the_runtime(octave, kind, tmp_path):
    for seed in range(3):
        design = design_of(kind, seed)
        samples, names = samples_of(design, seed)[:200], ",".join(code.signals(design))
        folder = tmp_path / str(seed)
        folder.mkdir()
        (folder / "controller.m").write_text(function(design, "controller"))
        np.savetxt(folder / "signals", samples, fmt="%.17g")
        files = folder, folder / "signals", names, folder / "commands"
        found, wanted = octave("evaluate_controller.m", *files), of_the_runtime(design, samples)
        size = np.nanmax(np.abs(wanted))
        np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-14 * size)
