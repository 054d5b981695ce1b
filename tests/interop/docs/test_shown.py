"""What the pages say that a command prints, it prints."""

import os
import re
import shlex
import shutil
import subprocess
from contextlib import chdir

import doc_pages
import pytest
from click.testing import CliRunner
from doc_pages import ROOT

from hfc_design.cli import main

DOCS = ROOT / "docs"
#: Those of tests/interop need other programs.
ELSEWHERE = ("fmu.md", "linuxcnc.md")
PAGES = [
    page
    for page in sorted(DOCS.glob("*.md"))
    if page.name not in ELSEWHERE and doc_pages.blocks(page, "console")
]


def printed(command, folder):
    """What a command of a page prints, without what a terminal fills its lines with."""
    words = shlex.split(command)
    with chdir(folder):
        if words[0] == "hfc":
            text = CliRunner().invoke(main, words[1:]).output
        else:
            done = subprocess.run(words, capture_output=True, text=True, check=True)
            text = done.stdout
    return [line.rstrip() for line in text.splitlines()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_console_blocks_show_what_is_printed(page, tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    os.symlink(DOCS, tmp_path / "docs")
    text = "".join(doc_pages.blocks(page, "console"))
    for command in re.findall(r"^hfc export \S+ --to c --out .*$", page.read_text(), re.MULTILINE):
        if f"$ {command}" not in text and "make" in text:
            printed(command, tmp_path)
    for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
        command, *shown = part.splitlines()
        assert printed(command, tmp_path) == shown, command
