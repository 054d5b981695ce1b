"""Rule bases of every kind, Mamdani's too, sampled to a table; see tests/interop/test_import.py.

The oracle of a single output is SciPy's quadrature of the aggregated set, written out here.
"""

import pytest
from imported_files import MAMDANI_FIS

from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish, imported

SIGNALS = {
    ".fll": {"level": "error", "rate": "error_change"},
    ".fis": {"Position error": "error", "d/dt error": "error_change"},
}


def taken(file, **wish):
    return imported(file, Wish(signals=SIGNALS[file.suffix], **wish))


def test_a_table_that_is_straight_between_its_terms_is_itself(tmp_path):
    """Triangles from centre to centre, product and weighted average: nothing to lose."""
    folder = tmp_path / "out"
    design = taken(MAMDANI_FIS, terms=(4, 6))
    FORMATS["fll"].write(design, folder)
    (file,) = folder.glob("*.fll")
    names = {"Position_error": "error", "d_dt_error": "error_change"}
    again = imported(file, Wish(signals=names, terms=(4, 6)))
    assert again.provenance["sampled"]["largest_deviation"] <= 1e-12
    assert again.controller.names == design.controller.names
    exact = imported(file, Wish(signals=names)).controller
    assert (exact.rules, exact.error_terms) == (
        design.controller.rules,
        design.controller.error_terms,
    )


@pytest.mark.parametrize("target", ["fll", "fcl", "fml", "fis", "st", "c", "csv"])
def test_names_of_a_file_get_into_no_code(tmp_path, target):
    """A name is a line of its own in every language, a comment's end, a formula."""
    hostile = "*) # --> =HYPERLINK() \\u000a} %"
    text = MAMDANI_FIS.read_text().replace("d/dt error", hostile).replace("'zero'", f"'{hostile}'")
    file = tmp_path / "hostile.fis"
    file.write_text(text.replace("%", "x"))
    name = hostile.replace("%", "x")
    design = imported(file, Wish(signals={"Position error": "error", name: "error_change"}))
    FORMATS[target].write(design, tmp_path / "out")
    out = tmp_path / "out"
    for part in [out] if out.is_file() else out.rglob("*"):
        found = part.read_text() if part.is_file() else ""
        assert "=HYPERLINK" not in found
        assert "HYPERLINK()" not in found
