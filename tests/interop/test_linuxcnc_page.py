"""The commands of docs/linuxcnc.md print what stands there."""

import re
import shlex
from contextlib import chdir
from pathlib import Path

from click.testing import CliRunner
from places import ROOT

from hfc_design.cli import main
from hfc_design.files.design import named_design
from hfc_design.formats import FORMATS

PAGE = ROOT / "docs" / "linuxcnc.md"


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


MOTION = """loadrt tpmod
loadrt homemod
loadrt trivkins
loadrt motmod servo_period_nsec=10000000 num_joints=2
addf motion-command-handler servo-thread
addf motion-controller servo-thread
"""


def test_lines_for_a_machine_fit_linuxcnc_itself(hal, tmp_path):
    (block,) = re.findall(r"```text\n(.*?)```", PAGE.read_text(), re.S)
    FORMATS["linuxcnc"].write(named_design("jee-koren-2004-aflc"), tmp_path / "out")
    hal.install(tmp_path / "out")
    (tmp_path / "out" / "machine.hal").write_text(f"{MOTION}{block}start\nshow thread\n")
    shown = hal.run(tmp_path / "out", "machine.hal")
    assert re.findall(r"^ +\d+ (\S+)", shown, re.M) == [
        "motion-command-handler",
        "motion-controller",
        "x-blu",
        "y-blu",
        "x-controller",
        "y-controller",
    ]
