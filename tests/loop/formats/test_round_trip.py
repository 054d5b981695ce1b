"""What another program called its controller is kept, from its file into a design and back.

The oracle is the file itself, read line by line; tests/interop/test_fll.py asks pyfuzzylite.
"""

import json
import re

import pytest
from click.testing import CliRunner
from exported import texts
from imported_files import SHARED, SHARED_SIGNALS
from wording import refused

import hfc_design.api as hfc
from hfc_design.cli import main
from hfc_design.controllers.flc.section import controller
from hfc_design.files.design import design_json, parse_design
from hfc_design.formats.reading import Wish, imported

#: What an export to FLL may say otherwise: it says what the file leaves to its program, and the
#: number of no rule at all, which never comes.
OTHERWISE = ("lock", "default", "disjunction", "implication", "RuleBlock")


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


def written(design, target="fll"):
    (text,) = (x for name, x in texts(design, target).items() if name.endswith(f".{target[:3]}"))
    return text


def said(text):
    """The lines without comments, numbers in one form."""
    lines = [re.sub("[#%].*", "", line).strip() for line in text.splitlines()]
    kept = [line for line in lines if line and not line.startswith(OTHERWISE)]
    return [re.sub(r"(?<![\w.])-?[\d.]+(?!\w)", lambda n: f"{float(n[0]):g}", x) for x in kept]


@pytest.mark.parametrize("suffix", SHARED)
def test_every_name_and_range_comes_back(suffix):
    design = imported(SHARED[suffix], Wish(signals=SHARED_SIGNALS))
    again = written(parse_design(design_json(design), "again"), suffix)
    found, wanted = said(again), said(SHARED[suffix].read_text())
    if suffix == "fis":  # flat beyond the range, as far as Octave needs it
        found, wanted = ([re.sub("(falls|rises)'.*", "", x) for x in y] for y in (found, wanted))
    assert found == wanted


def test_the_design_shows_the_file_s_names_and_none_of_ours(tmp_path):
    out = tmp_path / "mine.json"
    named = [f"--signal={name}={signal}" for name, signal in SHARED_SIGNALS.items()]
    done = CliRunner().invoke(main, ["import", str(SHARED["fll"]), "--out", str(out), *named])
    assert done.exit_code == 0, done.stderr
    text = out.read_text()
    assert '["c1", "c2", "c3"],\n    ["c2", "c3", "c4"],' in text  # a row a line
    assert not re.search(r'"(NL|NM|NS|ZR|PS|PM|PL|rules)"[,\]]', text)
    told = json.loads(text)
    assert told["provenance"]["terms"]["u"] == ["c1", "c2", "c3", "c4", "c5"]
    at = ["--at", "error=5,error_change=2"]
    shown = CliRunner().invoke(main, ["explain", str(out), *at]).stdout
    # Half of mid and high, half of still and rises: a quarter of each of four rules.
    for rule in ("mid still 25.00 % c3 0", "mid rises 25.00 % c4 6", "high rises 25.00 % c5 12"):
        assert rule in " ".join(shown.split())
    listing = controller(hfc.load_design(str(out)).controller).listing
    assert ["output term c2", "-6", "unit"] in listing.rows


def test_ranges_stay_where_the_design_is_within_them(tmp_path):
    """A range that no longer holds the table is that of the table, as of a design without one."""
    design = read(tmp_path, shared())
    rules = design.controller.rules
    rows = [[*rules.centroids[0]], [*rules.centroids[1]], [*rules.centroids[2][:2], 15.5]]
    outside = design.controller.model_copy(update={"rules": rules.moved(rows)})
    text = written(design.model_copy(update={"controller": outside}))
    assert "range: -12.0 15.5" in text
    assert "range: -5.0 5.0" in text
    terms = [*design.controller.error_change_terms]
    terms[2] = terms[2].model_copy(update={"centre": 5.5})
    wider = design.controller.model_copy(update={"error_change_terms": tuple(terms)})
    text = written(design.model_copy(update={"controller": wider}))
    assert "range: -8.0 11.0" in text  # 2 * 5.5 - 0
    assert "range: -15.0 15.0" in text


def test_a_range_has_to_rise():
    data = json.loads(design_json(hfc.load_design("jee-koren-2004-flc")))
    data["controller"]["ranges"] = {"output": [3.0, 3.0]}
    with refused():
        parse_design(json.dumps(data), "x.json")


def test_names_that_no_language_holds_become_some_that_differ(tmp_path):
    text = shared(a=("Engine: mine", "Engine: 2 ways"), b=("u is c1", "u is C2"))
    text = text.replace("term: c1 ", "term: C2 ")
    controller_ = read(tmp_path, text).controller
    assert controller_.names.engine == "engine_2_ways"
    assert controller_.rules.output_terms == {"C2": -12, "c2_2": -6, "c3": 0, "c4": 6, "c5": 12}


def test_an_output_term_that_stands_twice_is_refused(tmp_path):
    with refused() as found:
        read(tmp_path, shared(a=("term: c2 Constant -6", "term: c1 Constant -6")))
    assert found.where == f"{tmp_path / 'other.fll'}: line 23"
