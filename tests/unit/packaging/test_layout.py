"""Imports run down the list of docs/development.md only."""

import ast
import re

from places import ROOT

PAGE = (ROOT / "docs" / "development.md").read_text("utf-8")


def listed():
    """Folders and files of the package in the order in which the page tells of them."""
    table = PAGE.partition("## What is where")[2].partition("Imports run down")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    names = re.findall(r"`([\w/]+)(?:\.py)?`", "".join(rows))
    package = [name.removeprefix("hfc_design/").strip("/") for name in names]
    return package[: package.index("api") + 1]


def imported(file):
    """What of ours a file imports anywhere in it: names of folders, or of files at the top."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        for name in names:
            first, *rest = name.split(".")
            if first == "plants":
                yield first
            elif first == "hfc_design" and rest[0] != "__version__":
                yield rest[0]


def test_nothing_imports_what_comes_later():
    order = listed()
    assert order[:2] == ["plants", "core"]
    files = [*(ROOT / "plants").rglob("*.py"), *(ROOT / "hfc_design").rglob("*.py")]
    seen = set()
    for file in files:
        first, second, *_ = file.relative_to(ROOT).parts
        own = first if first == "plants" else second.removesuffix(".py")
        if own.startswith("__"):
            continue
        seen.add(own)
        for other in imported(file):
            assert order.index(other) <= order.index(own), f"{file} imports {other}"
    assert seen == set(order)
