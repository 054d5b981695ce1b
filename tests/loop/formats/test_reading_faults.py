"""Files that no design can hold are refused in one line with file and line."""

import pytest

from hfc_design.core.records import UserError
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish, imported

TABLES = {
    "rules.csv": [
        ("NL,-32.0", "NL,", "line 2: '' has to be a number"),
        ("\nNM,", "\nXX,", "line 3: 'XX' is no label in error_terms.csv"),
        ("\nNM,", "\nNL,", "line 3: a second rule"),
        ("PM,PL\n", "PM\n", "line 1: 7 cells"),
        ("\nPL,32.0,", "\nPL,", "line 8: 6 numbers; needed are 7"),
    ],
    "error_terms.csv": [
        ("centre_BLU", "centre", "line 1: the first line has to be"),
        ("NM,-19.0", "NM,-15.5", "line 1: input error, with its terms in the order of"),
        ("NL,,", "NL,-26,", "line 2: term NL, the lowest, has to be 1"),
        ("NM,-19.0,", "NM,,", "line 3: term NM: only the outermost reach infinity"),
        ("PL,16.0", "PL,nan", "line 8: 'nan' has to be a number"),
    ],
}


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [(name, *fault) for name, faults in TABLES.items() for fault in faults],
)
def test_faulty_tables(tmp_path, name, old, new, message):
    FORMATS["csv"].write(load_design("jee-koren-2004-flc"), tmp_path / "t")
    text = (tmp_path / "t" / name).read_text()
    assert old in text
    (tmp_path / "t" / name).write_text(text.replace(old, new, 1))
    with pytest.raises(UserError) as caught:
        imported(tmp_path / "t", Wish())
    assert f"{name}: {message}" in str(caught.value)


@pytest.mark.parametrize("text", ["", " \n\n"])
@pytest.mark.parametrize("name", ["mine.fll", "mine.fis", "rules.csv", "mine.txt", "mine.hal"])
def test_an_empty_file_is_called_so(tmp_path, name, text):
    for table in ("error_terms.csv", "error_change_terms.csv"):
        (tmp_path / table).write_text("label,left_BLU,centre_BLU,right_BLU\n")
    (tmp_path / name).write_text(text)
    like = "jee-koren-2004-aflc" if name.endswith((".txt", ".hal")) else None
    with pytest.raises(UserError) as caught:
        imported(tmp_path / name, Wish(like=like))
    assert str(caught.value).endswith(f"{name}: is empty")
