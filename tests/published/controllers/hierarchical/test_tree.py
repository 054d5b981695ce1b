"""Trees, genes and their evaluation (LL section 3.2)."""

import numpy as np
from hierarchies import valid


def test_six_inputs_have_4374990_valid_genes():
    numbers = np.arange(16**6, dtype=np.int32).reshape(16, -1)
    good = 0
    for chunk in numbers:
        digits = [(chunk >> shift) & 15 for shift in range(20, -1, -4)]
        good += np.count_nonzero(valid(np.stack(digits, axis=1).astype(np.int8)))
    assert good == 4_374_990
