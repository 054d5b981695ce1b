"""The page on a design names what to connect, how it was measured, and what it does."""

import re
import subprocess

import pytest
from flash_folders import FEW, written


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(tmp_path_factory.mktemp)


@pytest.mark.parametrize("name", FEW)
def test_the_call_to_begin_with_compiles_as_it_stands(name, folder):
    text = (folder(name) / "README.md").read_text()
    (snippet,) = (x for x in re.findall(r"```c\n(.*?)```", text, re.DOTALL) if "#include" in x)
    for precision in ([], ["-DHFC_FLOAT"]):
        command = [
            "gcc",
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-fsyntax-only",
            "-x",
            "c",
            "-",
        ]
        if precision and "has to be in double" in text:
            continue
        own = subprocess.run(
            [*command, f"-I{folder(name)}", *precision],
            input=snippet,
            text=True,
            capture_output=True,
            check=False,
        )
        assert own.returncode == 0, own.stderr
