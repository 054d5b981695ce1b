"""The C++ tool of fuzzylite, which reads FLL and FCL."""

import subprocess

import numpy as np

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
