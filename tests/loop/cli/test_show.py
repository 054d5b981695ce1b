"""``hfc show``: what it tells, how it fits, that it starts no JAX."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize(
    "asked", [["plant", "c-axis"], ["scenario", "c-axis-practical"], ["design", "pd-only"]]
)
def test_it_starts_no_jax(asked):
    code = f"""
import sys
from hfc_design.cli import main
main({["show", *asked]!r}, standalone_mode=False)
assert "jax" not in sys.modules
"""
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)
