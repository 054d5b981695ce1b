"""``python -m hfc_design`` is ``hfc``."""

import os
import sys

if sys.path[0] == os.getcwd():  # a plants.py that lies there would be taken for ours
    sys.path.append(sys.path.pop(0))

from hfc_design.cli import main

main(prog_name="hfc")
