"""Read-back tests: every exported format against the program that it is for."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hal_session import Unusable, session

HERE = Path(__file__).parent


@pytest.fixture
def program():
    """The path of an external program; the test is skipped where it is not installed."""

    def find(name):
        path = shutil.which(name)
        if path is None:
            pytest.skip(f"{name} is not installed; make interop installs it")
        return path

    return find


@pytest.fixture
def octave(program):
    """Run a script of this folder with arguments; the last is the table that it writes."""
    tool = program("octave-cli")

    def run(script, *arguments):
        command = [tool, "-q", str(HERE / script), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert Path(arguments[-1]).exists(), done.stderr
        return np.loadtxt(arguments[-1], delimiter=",")

    return run


@pytest.fixture
def hal(program):
    """LinuxCNC's HAL for one test, see ``hal_session``."""
    program("halcompile")
    program("halrun")
    try:
        with session() as found:
            yield found
    except Unusable as error:
        pytest.skip(str(error))
