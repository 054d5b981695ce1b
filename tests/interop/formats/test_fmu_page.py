"""The page inside an FMU: as HTML, of what its description names, and with nothing of a user's."""

import re
import zipfile
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest

from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS

TAGS = {"html", "head", "meta", "title", "style", "body", "h1", "h2", "h3", "p", "ul", "li"}
TAGS |= {"code", "pre", "table", "thead", "tbody", "tr", "th", "td"}
EVIL = '<script>alert(1)</script> <img src=x> &lt; | [x](javascript:y) `a` _b_ "'


class Read(HTMLParser):
    """Tags in their order, attributes, cells of tables, and all text."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.attributes, self.cells, self.text = [], set(), [], [], ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.attributes += attributes
        self.open += [tag] if tag != "meta" else []
        if tag == "td":
            self.cells.append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, text):
        self.text += text
        if "td" in self.open:
            self.cells[-1] += text


def pages(design, to, folder):
    """(page, description) of both FMUs."""
    FORMATS[to].write(design, folder)
    for path in sorted(folder.iterdir()):
        with zipfile.ZipFile(path) as archive:
            text = archive.read("documentation/index.html").decode()
            yield text, ElementTree.fromstring(archive.read("modelDescription.xml"))


@pytest.mark.parametrize("to", ["fmu", "fmu-plant", "fmu-loop"])
def test_the_page_names_every_variable_with_its_unit(to, tmp_path):
    (two, root), (three, _) = pages(load_design("lin-lee-1999-table-1"), to, tmp_path / "a")
    assert two == three
    read = Read(two)
    assert read.tags <= TAGS
    for variable in root.find("ModelVariables"):
        if variable.get("causality") == "independent":
            continue
        place = read.cells.index(variable.get("name"))
        columns = read.cells[place : place + 4]
        unit = variable.find("Real").get("unit")
        assert unit in columns[1:3], columns
        assert variable.get("description") in re.sub("; before .*", "", columns[3])
        if variable.get("causality") != "parameter":
            assert columns[1] == {"input": "in", "output": "out"}[variable.get("causality")]
    assert "has to be 0.001 s (1000 Hz)" in read.text
    assert ("ideal tachometer" in read.text) == ("The command is not limited" in read.text)
    assert ("The command is not limited" in read.text) == (to != "fmu-plant")


def test_the_page_of_a_machine_names_its_axes_and_limits(tmp_path):
    design = load_design("lin-gai-2009-fuzzy-sliding-compensated")
    read = Read(next(iter(pages(design, "fmu", tmp_path / "a")))[0])
    for axis in "xyzac":
        assert f"{axis}.error_rate" in read.cells
        assert f"{axis} 8.0" in read.text
    assert "what was learnt as well" in read.text


def test_what_a_user_wrote_is_text(tmp_path):
    design = load_design("pd-only")
    score = {"scenario": EVIL, f"{EVIL}_rms_error": 1.0, "max_error_rad": 2.0}
    own = {"source": EVIL, "scenario": design.provenance["scenario"]}
    plant = design.plant.model_copy(update={"name": EVIL})
    design = design.model_copy(
        update={"name": EVIL, "plant": plant, "score": score, "provenance": own}
    )
    read = Read(next(iter(pages(design, "fmu", tmp_path / "a")))[0])
    assert read.tags <= TAGS
    assert {name for name, _ in read.attributes} <= {"lang", "charset", "name", "content", "class"}
    assert f"source: {EVIL}" in read.text
    assert f"scenario {EVIL}, the largest" in read.text
    assert "_rms_error" not in read.text
