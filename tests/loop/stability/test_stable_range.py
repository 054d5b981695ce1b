"""The stable range against frequency responses, eigenvalues and grids of JK04 eq. 21 and 22."""

import subprocess
import sys


def test_stability_and_sectors_do_not_import_jax():
    code = (
        "import sys, hfc_design.stability.stable_range, hfc_design.stability.sectors;"
        "print('jax' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
