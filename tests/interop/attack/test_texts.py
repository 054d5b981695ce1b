"""Texts that would end a comment, a string, a cell or a line: none of them leaves as code."""

import io
import json
import subprocess
import zipfile
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
from along_a_line import along_a_line
from markdown_it import MarkdownIt

from hfc_design import api
from hfc_design.core.records import UserError
from hfc_design.files.design import parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.formats import FORMATS

#: With a mark that stands in no code.
EVIL = "*/ *) --> EVIL(); `touch x`; $(touch x) \" ' \\ ]]> | <script>EVIL()</script> %s {{ 1 }} //"
UNIT = "% (°C·N²)/µΩ"
CODE = {".c", ".h", ".st", ".comp", ".hal", ".m", ".fis", ".fll", ".fcl", ".fml", ".mk", ""}


class Parameters(NamedTuple):
    mass: float = 2.0


class State(NamedTuple):
    place: float
    speed: float


def step(p, x, force, loads, dt):
    return State(x.place + dt * x.speed, x.speed + dt * (force - loads[1]) / p.mass)


LINE = along_a_line("odd-line", UNIT, Parameters, State, step, meanings={"command": EVIL})


@pytest.fixture(params=["fuzzy", "learning", "own plant"])
def design(request):
    """One that was read from a file with such texts wherever they are taken."""
    name = {"fuzzy": "lin-lee-1999-table-1", "learning": "jee-koren-2004-aflc"}.get(request.param)
    data = load_design(name or "jee-koren-2004-pid").model_dump(mode="json")
    if not name:
        api.register(LINE)
        data["plant"] = {"name": LINE.name, "parameters": {"mass": 2.0}}
        data["provenance"] = {}
    data["provenance"] |= {"source": EVIL, EVIL: {EVIL: [EVIL]}, "names": {"e": EVIL}}
    data["score"] |= {"scenario": EVIL, EVIL: 1.0, f"{EVIL}_rms_error": 1.0, "rms_error": 1.0}
    return parse_design(json.dumps(data), "design.json")


def looked_at(name, content, folder):
    """Look at a file, and at what is packed in it."""
    ending = Path(name).suffix
    if ending == ".fmu":
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            for inner in archive.namelist():
                looked_at(inner, archive.read(inner), folder / Path(name).stem)
        return
    if ending in (".so", ".mat"):
        return
    text = content if isinstance(content, str) else content.decode()
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    if ending in CODE:
        assert "EVIL()" not in text
    if ending in (".xml", ".fml"):
        ElementTree.fromstring(text.encode())
    if ending == ".md":
        text = MarkdownIt("commonmark", {"html": True}).enable("table").render(text)
    if ending in (".md", ".html"):
        assert "<script" not in text
        assert "EVIL</" not in text


def each(content, name):
    """Every file of a folder in folders."""
    if isinstance(content, str | bytes):
        return [(name, content)]
    return [pair for key, part in content.items() for pair in each(part, f"{name}/{key}")]


@pytest.mark.parametrize("to", [name for name in FORMATS if name != "json"])  # which is data
def test_no_text_of_a_design_leaves_as_code(to, design, tmp_path):
    own = FORMATS[to]
    try:
        parts = [design] if own.whole else design.by_axis().values()
        contents = [own.content(part) for part in parts]
    except UserError as error:
        assert all(len(line) <= 300 and line.isprintable() for line in error.lines)
        return
    for k, content in enumerate(contents):
        for name, part in each(content, f"{k}{own.suffix}"):
            looked_at(name, part, tmp_path)
    for source in tmp_path.rglob("*.c"):
        include = f"-I{source.parent.parent}"  # of check/
        command = ["gcc", "-std=c99", "-Wall", "-Werror", "-fsyntax-only", include, source]
        subprocess.run(command, check=True)
    for makefile in tmp_path.rglob("Makefile"):
        subprocess.run(["make", "check"], cwd=makefile.parent, stdout=subprocess.PIPE, check=True)
    assert not list(tmp_path.rglob("x"))
