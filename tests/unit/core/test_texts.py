"""What the files of users say is read within limits; what is wrong is told in a line."""

import bz2
import gzip
import json
import lzma
import math
import os
import threading

import pytest
from pydantic import TypeAdapter, ValidationError
from wording import refused

from hfc_design.core.overrides import set_keys
from hfc_design.core.quantities import number
from hfc_design.core.records import LONGEST, Quantity, UserError
from hfc_design.core.texts import DEEPEST, LARGEST, MEGABYTE, json_of, read_text, read_toml, toml_of
from hfc_design.files.design import design_json, named_design, parse_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats.reading import Wish, imported
from hfc_design.motion.references import table_of


def line(read, *arguments):
    """With which a reader refuses; of parsers the words hang on their release."""
    with pytest.raises(UserError) as caught:
        read(*arguments)
    line = str(caught.value)
    assert len(line) <= LONGEST == 300 - len("hfc: ")
    assert line.isprintable()
    return line


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = " + "1" * 5000, "Exceeds the limit (4300 digits)"),
        ("x = 0x" + "f" * 5000, "an integer is larger than any float"),
        ("x = " + "[" * 80 + "]" * 80, "nested more than 64"),
        ("a" + ".a" * 50_000 + " = 1", "more than 64 parts"),
        ('"a b"' + " . 'a'" * 50_000 + " = 1", "more than 64 parts"),
        ('x = "\\ud800"', "not a Unicode scalar"),
        ("x = 1\nx = 2", "Cannot overwrite"),
    ],
)
def test_toml_that_breaks_its_parser_or_what_comes_after(text, words, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(text)
    told = line(read_toml, file)
    assert "mine.toml: is not valid TOML: " in told
    assert words.lower() in told.lower()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"a": ' + "1" * 5000 + "}", "Exceeds the limit (4300 digits)"),
        ("[" * 100_000, "nested more than 64"),
        ('{"name": "\\ud800"}', "half a character"),
        ('{"a": 1, "b": {"c": 1, "c": 1}}', "'c' is given twice"),
        ('{"a": NaN}', "NaN is not a number"),
        ("", "Expecting value"),
    ],
)
def test_json_that_breaks_its_parser_or_what_comes_after(text, words):
    told = line(parse_design, text, "mine.json")
    assert told.startswith("mine.json: is not valid JSON: ")
    assert words in told


def test_as_deep_as_is_allowed():
    assert json_of("[" * DEEPEST + "1" + "]" * DEEPEST)
    assert toml_of("x = " + "[" * (DEEPEST - 1) + "]" * (DEEPEST - 1))


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b", "\x1b[31m\u202e", "/dev/zero", "/"])
@pytest.mark.parametrize(
    "read",
    [
        load_scenario,
        named_design,
    ],
)
def test_names_that_no_file_can_have_and_files_without_end(read, name):
    line(read, name)


@pytest.mark.parametrize("pack", [gzip, bz2, lzma], ids=lambda module: module.__name__)
def test_what_is_packed_is_not_unpacked(pack, tmp_path):
    """4 MB of zeros are 4 kB of gzip; a name that ends in .gz alone is a table as any other."""
    packed = tmp_path / "table.csv.gz"
    packed.write_bytes(pack.compress(b"0,1\n1,2\n" * 1000))
    gcode = {"reference": {"kind": "gcode", "file": str(packed)}}
    for scenario in ({"load": {"file": str(packed)}}, gcode):
        with refused():
            load_scenario(scenario)
    packed.write_bytes(b"0,1\n1,2\n")
    assert table_of(packed)[1].tolist() == [1.0, 2.0]


def test_too_large(tmp_path):
    file = tmp_path / "large.toml"
    with file.open("wb") as opened:
        opened.truncate(10**12)  # takes no room
    with refused() as found:
        read_text(file)
    assert found.where == str(file)
    file.write_bytes(b"#" * LARGEST * MEGABYTE)
    assert read_toml(file) == {}


def test_a_named_pipe_keeps_nobody_waiting_and_the_end_of_a_pipe_is_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with refused():
        load_scenario(tmp_path / "pipe.toml")
    read, write = os.pipe()
    text = b'name = "piped"\nrun.seed = 7\n'
    threading.Thread(target=lambda: (os.write(write, text), os.close(write))).start()
    assert load_scenario(f"/dev/fd/{read}").run.seed == 7
    os.close(read)


def test_links_in_a_circle_and_files_that_can_be_read_once(tmp_path):
    (tmp_path / "a.toml").symlink_to(tmp_path / "b.toml")
    (tmp_path / "b.toml").symlink_to(tmp_path / "a.toml")
    for reads in (read_text, load_scenario):
        with refused():
            reads(tmp_path / "a.toml")
    read, write = os.pipe()
    os.write(write, b"0,1\n1,2\n")
    os.close(write)
    assert "read twice" in line(load_scenario, {"load": {"file": f"/dev/fd/{read}"}})
    os.close(read)


def test_changes_of_a_command_line():
    for change in (
        "a" + ".a" * 3000 + "=1",
        "description=\udcff",
        "run.seed=" + "1" * 5000,
        "run.seed=" + "[" * 3000,
    ):
        line(load_scenario, "c-axis-ramp", [change])
    line(load_scenario, {"description": "\udcff"})
    assert set_keys(['a="b"\nfoo=3'], "set") == {"a": '"b"\nfoo=3'}


def test_a_file_of_a_change_is_where_the_user_stands_else_beside_the_scenario(
    tmp_path, monkeypatch
):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "s.toml").write_text("[simulation]\nduration_s = 1.0\n")
    for name, top in (("there/a.csv", 1.0), ("a.csv", 2.0), ("there/b.csv", 3.0)):
        (tmp_path / name).write_text(f"t,r\n0,0\n1,{top}\n")
    monkeypatch.chdir(tmp_path)
    for name, top in (("a.csv", 2.0), ("b.csv", 3.0), ("there/a.csv", 1.0)):
        for change in (f"reference={{kind='csv',file='{name}'}}", f"reference.file={name}"):
            found = load_scenario("there/s.toml", ["reference.kind=csv", change])
            assert found.samples().axes[0].reference.max() == pytest.approx(top, abs=0.01)


def test_texts_in_a_design_keep_their_blanks():
    told = {"a  b": "1   2", "c": ["NL", "  A  A  "], "d": "[ 1,   2 ]", "e": ["NL", 'x\\"  [ 1 ]']}
    data = json.loads(design_json(named_design("jee-koren-2004-flc"))) | {"provenance": told}
    written = design_json(parse_design(json.dumps(data), "mine"))
    assert json.loads(written)["provenance"] == told
    assert '["NL", "NM", ' in written


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        ("fll", "Engine: a\nInputVariable: x\n  range: " + "1" * 100_000 + "x 3\n"),
        ("fll", "a" + " " * 100_000 + "b"),
        ("fis", "[System]\na" + " " * 100_000 + "b"),
        ("fis", "[System]\n" + "".join(f"k{k}=1\n" for k in range(15_000))),
        ("fis", "[System]\n[Rules]\n1" + " ," * 50_000 + "b"),
    ],
)
def test_100_kb_take_no_time(suffix, text, tmp_path):
    """Each took from seconds to minutes; a test that hangs says it."""
    file = tmp_path / f"mine.{suffix}"
    file.write_text(text)
    line(imported, file, Wish())


READ = TypeAdapter(Quantity).validate_python


@pytest.mark.parametrize(
    ("written", "unit", "found"),
    [
        ("20 urad", "rad", 20e-6),
        ("90 deg", "rad", math.pi / 2),
        ("0.1V", "V", 0.1),
        ("3 N m", "N m", 3.0),
        ("50 ms", "s", 0.05),
        ("10 BLU", "BLU", 10.0),
    ],
)
def test_quantities(written, unit, found):
    assert number(READ(written), unit) == pytest.approx(found, rel=1e-12)


def test_a_blu_has_millimetres():
    assert number("5 um", "BLU", 0.01) == pytest.approx(0.5)
    assert number("6 mm/min", "BLU/s", 0.01) == pytest.approx(10.0)


@pytest.mark.parametrize("written", ["20 V", "20 furlong", "2 unit"])
def test_of_something_else(written):
    with pytest.raises(ValueError, match="converts to rad"):
        number(READ(written), "rad")


@pytest.mark.parametrize(
    "written",
    [
        "20",
        "9**9**9 rad",
        "1e999 rad",
        "3 nothing",
        "1_0 rad",
        "１ rad",
    ],
)
def test_what_is_none(written):
    with pytest.raises(ValidationError, match=r"must be a number with a unit|unknown unit"):
        READ(written)


def test_dots_that_are_no_key():
    dots = ", ".join(["0.5"] * 500)
    text = f'a = [{dots}]\nb = "{"a." * 500}"\n# {"." * 300}\n' + ".".join("k" * 60) + " = 1"
    assert toml_of(text)["a"] == [0.5] * 500


@pytest.mark.parametrize(
    "change",
    ["sample_time_s=1e-320", "duration_s=1e308", "duration_s=1e300", "sample_time_s=1e-300"],
)
def test_steps_beyond_all_numbers(change):
    with refused():
        load_scenario("c-axis-ramp", [f"simulation.{change}"])
