"""Entry point: ``python -m hfc_design`` does the same as ``hfc``."""

import os
import sys

if sys.path[0] == os.getcwd():  # else Python would import a plants.py of this folder
    sys.path.append(sys.path.pop(0))

from hfc_design.cli import main

main(prog_name="hfc")
