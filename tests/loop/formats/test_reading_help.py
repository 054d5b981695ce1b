"""What a reader says of files that it does not take: how they can be taken, and what they lack."""

import pytest
from places import ROOT

from hfc_design.core.records import UserError
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish, imported

LESSON = (ROOT / "docs" / "lesson.fll").read_text()


@pytest.mark.parametrize(
    ("name", "target", "told"),
    [
        ("jee-koren-2004-flc", "fll", "as in hfc import {}/rules.fll"),
        ("lin-lee-1999-table-1", "fll", "units of a hierarchy"),
        ("lin-lee-1999-table-1", "csv", "a hierarchy's tables hold no terms"),
    ],
)
def test_a_folder_of_other_files(tmp_path, name, target, told):
    FORMATS[target].write(load_design(name), tmp_path / "out")
    with pytest.raises(UserError) as caught:
        imported(tmp_path / "out", Wish())
    assert told.format(tmp_path / "out") in str(caught.value)


def test_the_lesson_goes_back_to_its_language(tmp_path):
    """A term may be called none there: pyfuzzylite 8.0.6 reads such a file."""
    (tmp_path / "lesson.fll").write_text(LESSON)
    design = imported(tmp_path / "lesson.fll", Wish())
    FORMATS["fll"].write(design, tmp_path / "out")
    again = imported(tmp_path / "out" / "command.fll", Wish())
    assert again.controller == design.controller
