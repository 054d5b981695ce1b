"""uPlot is in the package as its release has it, with its licence."""

import hashlib
import re
from importlib.resources import files

from places import ROOT

MAKEFILE = (ROOT / "Makefile").read_text()
#: SHA-256 of the files in the npm release 1.6.32, whose own hash ``make uplot`` checks.
FILES = {
    "LICENSE": "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
    "uPlot.iife.min.js": "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
    "uPlot.min.css": "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
}


def test_the_files_are_those_of_the_release():
    folder = files("hfc_design.report") / "uplot"
    found = {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.iterdir()}
    assert found == FILES
    version = re.search(r"(?m)^UPLOT := (.*)$", MAKEFILE)[1]
    assert f"(v{version})" in (folder / "uPlot.iife.min.js").read_text(encoding="utf-8")[:80]
    assert (folder / "LICENSE").read_text().startswith("The MIT License")
