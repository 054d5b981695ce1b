"""Completion of a shell: names of everything, quickly, without JAX."""

import os
import subprocess
import sys


def test_a_shell_gets_names_without_jax():
    code = (
        "import sys\nfrom hfc_design.cli import main\n"
        "try:\n    main(prog_name='hfc')\nfinally:\n    print('jax' in sys.modules)"
    )
    asked = {"_HFC_COMPLETE": "bash_complete", "COMP_WORDS": "hfc design c-axis-s"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | asked | {"COMP_CWORD": "2"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.splitlines() == [
        "file,c-axis-s",
        "plain,c-axis-sine",
        "plain,c-axis-step",
        "False",
    ]
