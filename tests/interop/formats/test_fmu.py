"""FMUs without a program of others: what is in them, what their binary does, their page."""

import re
import zipfile
from html.parser import HTMLParser
from math import exp, inf, isfinite, nan
from xml.etree import ElementTree

import pytest
from fmi import ERROR, GOOD, WARNING, Slave

from hfc_design.core.records import RunError
from hfc_design.files.loop_setup import load_design
from hfc_design.formats import FORMATS, compiling
from hfc_design.runtime import Controller

AFLC = load_design("jee-koren-2004-aflc")
TABLE_1 = load_design("lin-lee-1999-table-1")
HOSTILE = 'x); system("id */ int main(void) {\n#define x <&\'"'


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """Of a design and a format the paths of the FMUs, which are compiled once."""
    known = {}

    def of(design, to="fmu"):
        if (design.name, to) not in known:
            folder = tmp_path_factory.mktemp("fmu") / "out"
            FORMATS[to].write(design, folder)
            known[design.name, to] = sorted(folder.iterdir())
        return known[design.name, to]

    return of


def page(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return archive.read("documentation/index.html").decode()


def described(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def test_the_plant_has_its_parameters_with_units_and_bounds(fmus):
    root = described(fmus(TABLE_1, "fmu-plant")[0])
    variables = {x.get("name"): x for x in root.iter("ScalarVariable")}
    inertia = variables["spindle_inertia"]
    assert (inertia.get("causality"), inertia.get("variability")) == ("parameter", "tunable")
    assert dict(inertia.find("Real").attrib) == {"unit": "kg m2", "min": "0.0", "start": "5.102"}
    assert variables["start.spindle_angle"].get("variability") == "fixed"
    outputs = {
        k: x.find("Real").get("unit")
        for k, x in variables.items()
        if x.get("causality") == "output"
    }
    assert outputs["state.bristle_deflection"] == "rad"
    assert outputs["deflection_rate"] == "rad/s"
    assert outputs["current"] == "A"
    units = {x.get("name"): x.find("BaseUnit") for x in root.iter("Unit")}
    assert units["kg m2"].attrib == {"kg": "1", "m": "2"}
    assert root.find("DefaultExperiment").get("stepSize") == "0.001"
    assert root.find("CoSimulation").get("canHandleVariableCommunicationStepSize") == "false"


def test_a_compiler_that_fails_is_told():
    with pytest.raises(
        RunError, match=r"cannot compile an FMU for x86_64-linux: a\.c:1:1: .*error"
    ):
        compiling.shared_library({"a.c": "nonsense"}, "a")


def test_no_code_comes_with_a_name(fmus):
    plant = TABLE_1.plant.model_copy(update={"name": HOSTILE})
    for fmu in fmus(TABLE_1.model_copy(update={"name": HOSTILE, "plant": plant})):
        with zipfile.ZipFile(fmu) as archive:
            names = [name for name in archive.namelist() if name.endswith((".c", ".h", ".xml"))]
            found = {name: archive.read(name).decode() for name in names}
        description = ElementTree.fromstring(found.pop("modelDescription.xml"))
        assert 'x); system("id' in description.get("description")
        assert len(found) > 4
        for text in found.values():
            assert 'system("' not in text
            assert "#define x <" not in text


@pytest.fixture
def slave(fmus, tmp_path):
    return Slave(fmus(AFLC)[0], tmp_path / "u")


def test_it_does_what_the_runtime_does_and_goes_on_from_a_state(slave):
    controller, errors = Controller(AFLC), [9.0, 12.0, -3.0, 7.0, 20.0, 1.0, -14.0, 5.0]
    expected = [controller.step({"error": x}) for x in errors]
    assert slave.begin() == GOOD

    def steps(some):
        found = []
        for x in some:
            slave.put(error=x)
            assert slave.step() == GOOD
            found.append(slave.get("command"))
        return found

    assert steps(errors[:4]) == expected[:4]
    state, time = slave.kept(), slave.time
    data = slave.written(state)
    assert steps(errors[4:]) == expected[4:]
    for before in (state, slave.read(data)[1]):
        assert slave.call("SetFMUstate", before) == GOOD
        slave.time = time
        assert steps(errors[4:]) == expected[4:]
    assert slave.call("Reset") == GOOD
    slave.time = 0.0
    assert slave.begin() == GOOD
    assert steps(errors) == expected
    assert slave.read(data[:-1])[0] == slave.read(b"x" + data[1:])[0] == ERROR
    assert slave.told[-1] == (ERROR, b"these bytes are no state of this FMU")


def test_another_step_is_an_error_that_is_told(slave):
    slave.begin()
    assert slave.step(0.02) == ERROR
    assert slave.told == [
        (ERROR, b"communicationStepSize = 0.02 s: has to be the sample time, 0.01 s")
    ]
    assert slave.step() == GOOD
    slave.time = 0.05
    assert slave.step() == ERROR
    assert (
        slave.told[-1][1] == b"currentCommunicationPoint = 0.05 s: the step before ended at 0.01 s"
    )


def test_a_faulty_sample_is_a_warning_that_is_told_once(slave):
    controller = Controller(AFLC)
    slave.begin()
    for x in (9.0, nan, inf, 4.0):
        expected = controller.step({"error": x})
        slave.put(error=x)
        assert slave.step() == (GOOD if isfinite(x) else WARNING)
        assert slave.get("command") == pytest.approx(expected, abs=0, nan_ok=True)
        assert slave.read(slave.written(slave.kept()))[0] == GOOD
    ((status, text),) = slave.told
    assert status == WARNING
    assert text.startswith(b"at 0.01 s an input is infinite or not a number")


def test_what_cannot_be_set_is_told(fmus, tmp_path):
    slave = Slave(fmus(TABLE_1, "fmu-plant")[0], tmp_path / "u")
    assert slave.begin(start__spindle_angle=0.5, start__rotor_angle=0.5) == GOOD
    assert slave.get("state.spindle_angle") == 0.5
    for value in (0.0, -1.0, nan, inf):
        assert slave.put(spindle_inertia=value) == ERROR
    assert slave.told[0][1] == b"spindle_inertia = 0 is beyond its range"
    assert slave.put(start__spindle_angle=0.1) == ERROR
    assert slave.put(state__current=0.1) == ERROR
    assert slave.put(spindle_inertia=6.0, command=50.0) == GOOD
    assert slave.step() == GOOD
    # L di/dt = u - R i in the first millisecond, before the rotor moves
    leakage, resistance = 0.341 - 0.225**2 / 0.306, 1.12 + 1.05 * 0.341 / 0.306
    current = 50.0 / resistance * (1.0 - exp(-resistance / leakage * 1e-3))
    assert slave.get("state.current") == pytest.approx(current, rel=1e-3)
    slave.put(load=inf)
    before = slave.get("state.current")
    assert slave.step() == WARNING
    assert slave.get("state.current") == before
    assert slave.told[-1][1].endswith(b"the machine and its control stay as they were")


def test_the_same_design_gives_the_same_bytes(fmus, tmp_path):
    first, other = fmus(AFLC), fmus(load_design("jee-koren-2004-flc"))
    assert [x.name for x in first] == [f"jee_koren_2004_aflc_fmi{k}.fmu" for k in (2, 3)]
    FORMATS["fmu"].write(AFLC, tmp_path / "b")
    assert all(x.read_bytes() == (tmp_path / "b" / x.name).read_bytes() for x in first)
    guids = [described(x).get("guid") for x in (*first, *other)]
    assert len(set(guids)) == 3  # FMI 3.0 has none
    assert re.fullmatch(r"\{[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\}", guids[0])


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


@pytest.mark.parametrize("to", ["fmu", "fmu-plant", "fmu-loop"])
def test_the_page_names_every_variable_with_its_unit(to, fmus):
    two, three = fmus(TABLE_1, to)
    assert page(two) == page(three)
    read, root = Read(page(two)), described(two)
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
    assert "must be 0.001 s (1000 Hz)" in read.text
    assert ("ideal tachometer" in read.text) == ("The command is not limited" in read.text)
    assert ("The command is not limited" in read.text) == (to != "fmu-plant")


def test_what_a_user_wrote_is_text(fmus):
    design = load_design("pd-only")
    score = {"scenario": EVIL, f"{EVIL}_rms_error": 1.0, "max_error_rad": 2.0}
    own = {"source": EVIL, "scenario": design.provenance["scenario"]}
    plant = design.plant.model_copy(update={"name": EVIL})
    design = design.model_copy(
        update={"name": EVIL, "plant": plant, "score": score, "provenance": own}
    )
    read = Read(page(fmus(design)[0]))
    assert read.tags <= TAGS
    assert {name for name, _ in read.attributes} <= {"lang", "charset", "name", "content", "class"}
    assert f"source: {EVIL}" in read.text
    assert f"scenario {EVIL}, the largest" in read.text
    assert "_rms_error" not in read.text
