"""The commands of docs/linuxcnc.md print what stands there."""

import re
import shlex
from contextlib import chdir
from pathlib import Path

import pytest
from click.testing import CliRunner

from hfc_design.cli import main

pytestmark = pytest.mark.interop

PAGE = Path(__file__).parents[2] / "docs" / "linuxcnc.md"


def transcript(hal, block, folder):
    """The commands of a console block, each with what it prints now."""
    lines = []
    for line in block.splitlines():
        if not line.startswith("$ "):
            continue
        lines.append(line)
        words = shlex.split(line.removeprefix("$ ").removeprefix("sudo "))
        if words[0] == "cd":
            folder /= words[1]
            continue
        if words[0] == "halcompile":
            hal.about_to_install(Path(words[-1]).stem)
        if words[0] == "hfc":
            with chdir(folder):
                printed = CliRunner().invoke(main, words[1:]).output
        elif words[0] == "halrun":
            printed = hal.run(folder, words[1])
        else:
            printed = hal.call(*words, cwd=folder)
        lines += [shown.rstrip() for shown in printed.splitlines()]
    return "\n".join(lines) + "\n"


def test_page_shows_what_the_commands_print(hal, tmp_path):
    (block,) = re.findall(r"```console\n(.*?)```", PAGE.read_text(), re.S)
    assert transcript(hal, block, tmp_path) == block
