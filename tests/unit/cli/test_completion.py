"""Completion of a shell: names of everything, quickly, without JAX."""

import os
import shutil
import subprocess
import sys

import pytest
from click.shell_completion import BashComplete, FishComplete, ZshComplete

from hfc_design.cli import main
from hfc_design.files.design import builtin_designs
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.files.named_scenario import builtin_names
from hfc_design.formats import FORMATS
from hfc_design.objectives.judge import OBJECTIVES
from hfc_design.search.loop import STRATEGIES

SHELLS = BashComplete, ZshComplete, FishComplete


def completed(*words, shell=BashComplete):
    """The names that a shell offers for the last word."""
    *before, last = words
    own = shell(main, {}, "hfc", "_HFC_COMPLETE")
    return [one.value for one in own.get_completions(before, last) if one.type == "plain"]


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize(
    ("words", "names"),
    [
        (["design"], builtin_names()),
        (["score"], builtin_designs()),
        (["design", "--preset"], sorted(STRATEGIES.built_in)),
        (["design", "--plant"], sorted(ALL_PLANTS.built_in)),
        (["design", "--fitness"], sorted(OBJECTIVES.built_in)),
        (["plot"], builtin_designs()),
        (["show", "format"], sorted(FORMATS)),
    ],
)
def test_every_name_is_offered(shell, words, names):
    assert sorted(completed(*words, "", shell=shell)) == sorted(names)


@pytest.mark.parametrize("shell", SHELLS)
def test_what_begins_like_it_is_offered(shell):
    assert completed("des", shell=shell) == ["design"]
    assert completed("design", "mine", shell=shell) == []  # a shell looks for files then
    assert completed("score", "lin-lee", shell=shell) == [
        "lin-lee-1999-table-1",
        "lin-lee-1999-table-2",
    ]
    assert completed("design", "--pre", shell=shell) == ["--preset", "--precision"]
    assert completed("export", "pd-only", "--to", "fm", shell=shell) == [
        *("fml", "fmu", "fmu-loop", "fmu-plant")
    ]


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no Bash here")
def test_bash_takes_what_it_is_offered(tmp_path):
    """The script of the page, in a shell whose own half is played by the test."""
    (tmp_path / "hfc").write_text(f'#!/bin/sh\nexec {sys.executable} -m hfc_design "$@"\n')
    (tmp_path / "hfc").chmod(0o755)
    script = (
        "compopt() { :; }; complete() { :; }\n"
        'eval "$(_HFC_COMPLETE=bash_source hfc)"\n'
        "COMP_WORDS=(hfc export pd-only --to fm); COMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n"
        "_hfc_completion hfc\n"
        'printf "%s\\n" "${COMPREPLY[@]}"\n'
    )
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "--norc", "-c", script],
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    assert done.stdout.split() == ["fml", "fmu", "fmu-loop", "fmu-plant"]
