"""Random designs of every kind of an axis: their C commands what the runtime does, bit for bit.

With products that the compiler does not fuse; both take exp and tanh from the same library.
"""

import numpy as np
import pytest
from attack import FULL
from c_program import together
from random_designs import MADE, design_of, of_the_runtime, samples_of

SEEDS = range(200 if FULL else 6)
#: Programs of so many designs each.
TOGETHER = 25


@pytest.mark.parametrize("kind", MADE)
def test_commands_are_those_of_the_runtime(program, kind, tmp_path):
    program("gcc")
    for first in range(0, len(SEEDS), TOGETHER):
        seeds = SEEDS[first : first + TOGETHER]
        designs = {seed: design_of(kind, seed) for seed in seeds}
        folder = tmp_path / str(first)
        folder.mkdir()
        run = together(designs, folder, "-ffp-contract=off")
        for seed, design in designs.items():
            samples = samples_of(design, seed)
            wanted = of_the_runtime(design, samples)
            assert np.isfinite(wanted).any()
            np.testing.assert_array_equal(run(seed, samples), wanted, err_msg=f"{kind} {seed}")
