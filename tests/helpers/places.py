"""Where tests find what they read."""

from pathlib import Path

TESTS = Path(__file__).parents[1]
ROOT = TESTS.parent
DATA = TESTS / "data"
#: A kind of controller and a machine that belong to nobody but these tests.
OWN_PARTS = TESTS / "own_parts"
