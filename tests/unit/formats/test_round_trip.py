"""What another program called its controller is kept, from its file into a design and back.

The oracle is the file itself, read line by line; tests/interop/test_fll.py asks pyfuzzylite.
"""

import re

import pytest
from imported_files import GAUSSIAN, SHARED, SHARED_SIGNALS

from hfc_design.core.records import UserError
from hfc_design.formats.reading import Wish, imported


def shared(suffix="fll", **changes):
    """The design of the file by hand, with texts in it changed."""
    text = SHARED[suffix].read_text()
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new)
    return text


def read(tmp_path, text, suffix="fll", **wish):
    file = tmp_path / f"other.{suffix}"
    file.write_text(text)
    return imported(file, Wish(signals=SHARED_SIGNALS, **wish))


def test_names_that_no_language_holds_become_some_that_differ(tmp_path):
    text = shared(a=("Engine: mine", "Engine: 2 ways"), b=("u is c1", "u is C2"))
    text = text.replace("term: c1 ", "term: C2 ")
    controller_ = read(tmp_path, text).controller
    assert controller_.names.engine == "engine_2_ways"
    assert controller_.rules.output_terms == {"C2": -12, "c2_2": -6, "c3": 0, "c4": 6, "c5": 12}


def test_an_output_term_that_stands_twice_is_refused(tmp_path):
    with pytest.raises(UserError, match="line 23: term c1 stands twice in output u"):
        read(tmp_path, shared(a=("term: c2 Constant -6", "term: c1 Constant -6")))


def test_terms_of_a_hierarchy_have_names_of_the_file(tmp_path):
    text = re.sub(r"\bf(\d)\b", r"level-\1", GAUSSIAN.read_text())
    (tmp_path / "own.fll").write_text(text)
    labels = [term.label for term in imported(tmp_path / "own.fll", Wish()).controller.terms]
    assert labels == [f"level_{k}" for k in range(1, 8)]
