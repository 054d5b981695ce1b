"""Controllers of other programs, read back as designs."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import wiring
from click.testing import CliRunner
from imported_files import CHANGE, GAUSSIAN, OCTAVE, PYFUZZYLITE, TABLE, TEXTS, triangles

from hfc_design.cli import main
from hfc_design.controllers.flc.rules import LABELS
from hfc_design.core.records import UserError
from hfc_design.files.design import design_json
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish, imported
from hfc_design.runs import run as designs
from hfc_design.runtime import Controller
from hfc_design.simulation.evaluating import evaluate

FLC = "jee-koren-2004-flc"


def controller_of(path, **wish):
    return imported(path, Wish(**wish)).controller


@pytest.mark.parametrize("file", [PYFUZZYLITE, OCTAVE])
def test_what_the_real_programs_wrote_of_the_published_controller(file):
    found = imported(file, Wish(name="mine"))
    own, controller = load_design(FLC).controller, found.controller
    terms = dict(zip(LABELS, (-32.0, -16.0, -8.0, 0.0, 8.0, 16.0, 32.0), strict=True))
    assert controller.rules == own.rules.model_copy(update={"output_terms": terms})
    assert controller.names.output == "command"
    assert controller.ranges == {"error": (-30.0, 30.0), "error_change": (-6.0, 6.0)}
    changes = {"rules": own.rules, "names": own.names, "ranges": {}}
    assert controller.model_copy(update=changes) == own
    assert (found.name, found.plant.name) == ("mine", "feed-drive")
    assert found.provenance["source"] == f"imported from {file.name}"
    assert list(found.provenance["sha256"]) == [file.name]
    assert re.fullmatch("[0-9a-f]{64}", found.provenance["sha256"][file.name])


def test_flat_gaussians_are_a_hierarchy_of_one_unit_alone():
    """The pyfuzzylite file's own output at some points is the weighted average by hand."""
    design = imported(GAUSSIAN, Wish())
    unit = design.controller.units[0]
    assert design.controller.pd.kp == design.controller.pd.kd == 0.0
    assert (unit.row_input, unit.column_input) == ("deflection", "error")[::-1]
    terms = load_design("lin-lee-1999-table-1").controller.terms
    numbers = [(t.label, t.centre, t.half_width, t.rate) for t in design.controller.terms]
    for found, term in zip(numbers, terms, strict=True):
        assert found == (term.label, term.centre, term.half_width, pytest.approx(term.rate, 1e-15))
    rows = {"error": [], "deflection": []}
    for name, u in (("error", 0.3), ("deflection", -0.7)):
        distances = [max(abs(u - t.centre) - t.half_width, 0.0) for t in terms]
        rows[name] = [np.exp(-t.rate * d * d) for t, d in zip(terms, distances, strict=True)]
    column = sum(j * d for j, d in enumerate(rows["error"])) / sum(rows["error"])
    row = sum(i * d for i, d in enumerate(rows["deflection"])) / sum(rows["deflection"])
    signals = {"error": 0.3, "error_rate": 9.0, "deflection": -0.7}
    assert Controller(design).step(signals) == pytest.approx(row - column / 2, abs=1e-12)


@pytest.mark.parametrize("suffix", TEXTS)
def test_terms_in_any_order_are_sorted_and_the_table_with_them(tmp_path, suffix):
    file = tmp_path / f"mine.{suffix}"
    file.write_text(TEXTS[suffix])
    found = controller_of(file, signals=CHANGE)
    for terms in (found.error_terms, found.error_change_terms):
        edges = [(t.left, t.centre, t.right) for t in terms]
        assert edges == [row[1:] for row in triangles(range(7))]
    assert [list(row) for row in found.rules.centroids] == TABLE
    # With the signals named the other way round the table is the transposed one.
    other = controller_of(file, signals={"change": "error", "error": "error_change"})
    assert [list(row) for row in zip(*other.rules.centroids, strict=True)] == TABLE


#: (error, change, output) of the texts above in pyfuzzylite 8.0.6; Octave's fuzzy-logic-toolkit
#: 0.4.6 gives the same but for 1e-14, with linzmf and linsmf, which only MATLAB has, as trapmf.
THE_PROGRAMS_SAY = [
    (-4.425, -7.282, -2.7178249257424683),
    (-0.985, -6.168, -26.804041613344157),
    (-8.07, -0.866, 19.169686756311147),
    (10.236, 7.71, -14.39653818159953),
    (6.951, -4.729, -2.9608886974273987),
    (2.039, -3.551, 0.8227702208369054),
    (-5.788, -7.217, -1.05006906668974),
    (-4.89, 10.441, 2.197253485598709),
    (-9.5, 12.0, 23.46720670093304),
    (-6.0, 0.25, -19.279320662762114),
    (1.7, -0.9, 11.154143876630698),
]


@pytest.mark.parametrize("suffix", TEXTS)
def test_the_design_computes_what_the_real_programs_do(tmp_path, suffix):
    file = tmp_path / f"mine.{suffix}"
    file.write_text(TEXTS[suffix])
    runtime = Controller(imported(file, Wish(signals=CHANGE)))
    for error, change, output in THE_PROGRAMS_SAY:
        runtime.remember({"error": error - change})
        assert runtime.step({"error": error}) == pytest.approx(output, abs=1e-12)


def test_what_the_file_does_not_hold_comes_from_another_design(tmp_path):
    file = tmp_path / "mine.fll"
    file.write_text(TEXTS["fll"])
    aflc = load_design("jee-koren-2004-aflc")
    adapting = controller_of(file, kind="aflc", signals=CHANGE)
    own = aflc.controller.adaptation.model_copy(update={"smallest_overlap": None})
    assert adapting.adaptation == own
    assert adapting.rules == controller_of(file, signals=CHANGE).rules
    with pytest.raises(UserError, match=r"smallest_overlap\.error = 3\.0: has to be at most"):
        controller_of(file, like="jee-koren-2004-aflc", signals=CHANGE)  # whose terms are wider
    like = controller_of(file, like=FLC, sample_time=0.002, signals=CHANGE)
    assert like == controller_of(file, signals=CHANGE).model_copy(update={"sample_time_s": 0.002})
    root = controller_of(GAUSSIAN, like="lin-lee-1999-table-1")
    assert (root.pd.kp, root.output_scale) == (758.405, 10.0)
    assert {item.name: item.scale for item in root.inputs} == {"error": 50.0, "deflection": 80.0}
    with pytest.raises(UserError, match=r"like='pd-only': has to be of kind flc or aflc or pd"):
        imported(file, Wish(like="pd-only"))
    with pytest.raises(UserError, match=r"kind flc needs triangles"):
        imported(GAUSSIAN, Wish(kind="flc"))


EXPORTS = [
    (name, target) for name in (FLC, "jee-koren-2004-aflc") for target in ("csv", "fll", "fis")
]
EXPORTS += [("made-up", target) for target in ("fll", "fis")]
EXPORTS += [(size, target) for size in ("5x3", "2x11") for target in ("csv", "fll", "fis")]
#: Whose input is which signal, of a file that calls them by its own names.
SIGNALS = {"gap": "error", "drift": "error_change"}


@pytest.mark.parametrize(("name", "target"), EXPORTS)
def test_exported_and_imported_it_is_the_same_controller(tmp_path, name, target):
    if target not in FORMATS:
        pytest.skip(f"there is no export to {target}")
    design = unit_alone() if name == "made-up" else wiring.design(name)
    folder = tmp_path / "exported"
    FORMATS[target].write(design, folder)
    path = folder if target == "csv" else next(folder.glob(f"*.{target}"))
    called = {"signals": SIGNALS} if name[0].isdigit() and target != "csv" else {}
    found = controller_of(path, kind=design.controller.kind, **called)
    if target == "csv":
        assert controller_of(folder / "rules.csv", kind=design.controller.kind) == found
    bare = {"integral_gain": 0.0, "low_velocity": None} if name[0].isdigit() else {}
    assert found == design.controller.model_copy(update=bare)


def unit_alone():
    design = load_design("lin-lee-1999-table-1")
    unit = {"id": 0, "column_input": "error", "row_input": "deflection"}
    data = design.model_dump()
    data["controller"] |= {
        "pd": {"kp": 0.0, "kd": 0.0},
        "output_scale": 1.0,
        "inputs": [{"name": name, "scale": 1.0} for name in ("error", "deflection")],
        "units": [unit | {"consequents": TABLE}],
    }
    return type(design).model_validate(data)


@pytest.mark.slow
def test_the_command_writes_a_design_that_a_search_starts_from(tmp_path, no_baselines):
    def hfc(*arguments):
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    out = tmp_path / "mine.json"
    done = hfc("import", PYFUZZYLITE, "--out", out, "--kind", "flc")
    assert done.exit_code == 0
    assumed = "plant feed-drive, sample time 0.01 s assumed: --plant, --sample-time"
    assert done.stdout == f"{assumed}\n{out}\n"
    assert "exists already" in hfc("import", OCTAVE, "--out", out).stderr
    assert "INPUT=SIGNAL" in hfc("import", OCTAVE, "--signal", "error").stderr
    assert json.loads(out.read_text())["name"] == "pyfuzzylite-8.0.6"
    scenario = tmp_path / "mine.toml"
    circle = load_scenario("feed-drive-circle").model_dump(mode="json", exclude_none=True)
    assert circle["controller"]["kind"] == "aflc"
    text = (
        Path(designs.__file__).parents[1] / "files" / "scenarios" / "feed-drive-circle.toml"
    ).read_text()
    scenario.write_text(text.replace('kind = "aflc"', 'kind = "flc"\nstart = "mine.json"'))
    small = ["--population", 8, "--generations", 2, "--set", "simulation.duration_s=4.0"]
    done = hfc("design", scenario, "--out", tmp_path / "run", "--quiet", *small)
    assert done.exit_code == 0, done.stderr
    found = load_design(str(tmp_path / "run"))
    assert found.controller.kind == "flc"
    assert evaluate(found, load_scenario(str(scenario), ["simulation.duration_s=4.0"])).fitness > 0


def test_a_search_does_not_start_from_terms_that_it_would_move(tmp_path):
    (tmp_path / "lopsided.fll").write_text(TEXTS["fll"])
    found = imported(tmp_path / "lopsided.fll", Wish(signals=CHANGE))  # ZR is centred on 0.25
    (tmp_path / "lopsided.json").write_text(design_json(found))
    start = f"controller.start={tmp_path / 'lopsided.json'}"
    with pytest.raises(
        UserError, match=r"e3 of its error_terms is centred on 0.25; a search keeps"
    ):
        load_scenario("feed-drive-circle", ["controller.kind=flc", start])
