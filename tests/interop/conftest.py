"""Read-back tests: every exported format against the program that it is for."""

import shutil

import pytest
from hal_session import Unusable, session


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
def hal(program):
    """LinuxCNC's HAL for one test, see ``hal_session``."""
    program("halcompile")
    program("halrun")
    try:
        with session() as found:
            yield found
    except Unusable as error:
        pytest.skip(str(error))
