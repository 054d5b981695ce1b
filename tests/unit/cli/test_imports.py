"""What is told quickly: no command here waits for JAX, or for what draws."""

import os
import subprocess
import sys

#: In one process, the lightest first: after each nothing heavy has been imported.
CODE = """
import os, sys
from hfc_design.cli import main
HEAVY = {"jax", "matplotlib"}
for heavy, *words in (
    [{*HEAVY, "numpy"}, "--help"],
    [HEAVY, "show", "plant", "c-axis"],
    [HEAVY, "show", "scenario", "c-axis-practical"],
    [HEAVY, "show", "design", "pd-only"],
    [HEAVY, "init", "--out", "mine.toml"],
    [HEAVY, "stability", "--json"],
    [HEAVY],
    [{"matplotlib"}, "list", "plants"],
):
    if not words:  # a shell asks for names
        os.environ |= {"_HFC_COMPLETE": "bash_complete", "COMP_WORDS": "hfc design c-axis-s"}
        os.environ["COMP_CWORD"] = "2"
    try:
        main(words, prog_name="hfc")
    except SystemExit:
        pass
    print("done")
    os.environ.pop("_HFC_COMPLETE", None)
    assert not heavy & {name.partition(".")[0] for name in sys.modules}, words
"""


def test_nothing_heavy_is_imported(tmp_path):
    told = [sys.executable, "-c", CODE]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        told, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment
    )
    assert done.returncode == 0, done.stderr
    names = done.stdout.split("done\n")[6].splitlines()
    assert names == ["file,c-axis-s", "plain,c-axis-sine", "plain,c-axis-step"]
