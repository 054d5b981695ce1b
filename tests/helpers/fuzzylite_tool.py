"""fuzzylite: its C++ tool, which reads FLL and FCL, and pyfuzzylite."""

import json
import subprocess

import numpy as np
import pytest
from places import TESTS

PYTHON = TESTS.parent / ".venv-fuzzylite" / "bin" / "python"
OPTIONS = ["-of", "fld", "-decimals", "15", "-dheader", "false", "-dinputs", "false"]


def in_tool(tool, table, language, file, _row, _column, points):
    """Points through the C++ tool: a table of points in, a table of outputs out."""
    np.savetxt(table, points, fmt="%.17g")
    done = subprocess.run(
        [tool, "-i", str(file), "-if", language, "-d", str(table), *OPTIONS, "-o", f"{table}.out"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert not done.stdout, done.stdout  # it says there what is wrong, and ends with 0
    return np.loadtxt(f"{table}.out")


def in_python(script, *arguments, **job):
    """What a script of tests/interop says in the environment of pyfuzzylite, of a job or a file."""
    if not PYTHON.exists():
        pytest.skip("pyfuzzylite is not installed; make interop installs it")
    command = [PYTHON, TESTS / "interop" / script, *arguments]
    done = subprocess.run(
        command, input=json.dumps(job), capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)
