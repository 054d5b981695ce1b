"""``python -m hfc_design`` is ``hfc``."""

from hfc_design.cli import main

main(prog_name="hfc")
