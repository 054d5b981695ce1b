"""Controllers of other programs, read back as designs."""

import re

import pytest
import wiring
from imported_files import CHANGE, GAUSSIAN, OCTAVE, PYFUZZYLITE, TABLE, TEXTS

from hfc_design.controllers.flc.rules import LABELS
from hfc_design.core.records import UserError
from hfc_design.files.design import design_json
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish, imported

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


def test_a_search_does_not_start_from_terms_that_it_would_move(tmp_path):
    (tmp_path / "lopsided.fll").write_text(TEXTS["fll"])
    found = imported(tmp_path / "lopsided.fll", Wish(signals=CHANGE))  # ZR is centred on 0.25
    (tmp_path / "lopsided.json").write_text(design_json(found))
    start = f"controller.start={tmp_path / 'lopsided.json'}"
    with pytest.raises(
        UserError, match=r"e3 of its error_terms is centred on 0.25; a search keeps"
    ):
        load_scenario("feed-drive-circle", ["controller.kind=flc", start])
