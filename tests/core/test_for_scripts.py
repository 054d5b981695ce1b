"""Messages are written in the words of the command line; a script reads its own arguments."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import hfc_design
import hfc_design.api as hfc
from hfc_design.controllers.neural.training import Lesson
from hfc_design.core.for_scripts import ARGUMENTS, FLAGS, for_scripts
from hfc_design.formats.reading import Wish

FOLDER = Path(hfc_design.__file__).parent
#: Options of messages that only the command line can cause, or of other programs.
OF_SHELLS = {"lookup", "parquet", "scheduler", "shared", "tls-ca", "tls-cert", "tls-key"}
OF_SHELLS |= {"build-id", "pareto", "use", "ab", "ba"}
RAMP = hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})


def texts():
    """Every text of the package with an option in it, holes of a template as X."""
    for path in sorted(FOLDER.rglob("*.py")):
        if path.is_relative_to(FOLDER / "cli"):
            continue
        tree = ast.parse(path.read_text())
        inner = {id(x) for one in ast.walk(tree) for x in getattr(one, "values", ())}
        told = {id(x.value) for x in ast.walk(tree) if isinstance(x, ast.Expr)}
        for one in ast.walk(tree):
            if id(one) in told or id(one) in inner:
                continue
            if isinstance(one, ast.JoinedStr):
                text = "".join(x.value if isinstance(x, ast.Constant) else "X" for x in one.values)
            else:
                text = getattr(one, "value", None)
            if isinstance(text, str) and re.search(r"(?<!\w)--(?!xla)[a-z]", text):
                yield f"{path.relative_to(FOLDER)}:{one.lineno}", text


def arguments():
    """Every argument that a function of the API has."""
    found = {*Wish._fields, *Lesson._fields, "sample"}  # explain(design, *samples)
    for name in hfc.__all__:
        if inspect.isroutine(thing := getattr(hfc, name)):
            found |= {*inspect.signature(thing).parameters}
    return found | {*inspect.signature(hfc.Scenario.motion).parameters}


def test_no_message_of_the_package_leaves_a_script_with_an_option():
    seen = 0
    for place, text in texts():
        seen += 1
        left = re.sub(r"\bhfc [a-z]+ .*", "", for_scripts(text))
        options = {*re.findall(r"(?<![\w-])--([a-z][a-z-]*)", left)} - OF_SHELLS
        assert not options, (place, text, for_scripts(text))
    assert seen > 60


def test_what_a_script_is_told_are_arguments_of_its_functions():
    assert {*ARGUMENTS.values()} - arguments() == set()
    assert {told.partition("=")[0] for told in FLAGS.values()} - arguments() == set()


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("--samples 0: has to lie", "samples=0: has to lie"),
        ("--plant mine: is for", "plant='mine': is for"),
        ("--set a.b=5: a is not a table", "changes={'a.b': 5}: a is not a table"),
        ("x.csv: look for fewer with --free", "x.csv: look for fewer with free="),
        ("replay it with --open-loop", "replay it with bandwidth=0"),
        ("with --anyway it goes on", "with anyway=True it goes on"),
        ("own by --use module:OBJECT", "own by hfc.register(module.OBJECT)"),
        ("none; hfc pick run --point 3 --out a makes one",) * 2,
        ("--scheduler here: no answer",) * 2,
        ("a--set of -- things",) * 2,
    ],
)
def test_a_line_in_the_words_of_a_script(typed, told):
    error = hfc.UserError(typed)
    assert (str(error), error.lines) == (told, [typed])


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, 0), "samples=0: has to lie between 1 and"),
        (lambda: hfc.robustness("pd-only", RAMP, 2.0, 5), "spread=2.0: has to lie between 0"),
        (
            lambda: hfc.compare(["pd-only", "lin-lee-1999-table-2"], machines=0),
            "machines=0: has to",
        ),
        (lambda: hfc.load_design("pd-only", ["x"]), "changes: x: has to look like KEY=VALUE"),
        (lambda: hfc.load_scenario(RAMP, {"name.b": 5}), "changes={'name.b': 5}: name is not a"),
        (lambda: hfc.explain("jee-koren-2004-flc", "x"), "sample: 'x': has to be SIGNAL=NUMBER"),
        (lambda: hfc.picture("lin-lee-1999-table-2", "surface", "u"), "unit='u': surface of"),
        (lambda: hfc.identify("x.csv"), r"which machine is it\? say plant=, scenario= or cont"),
        (lambda: hfc.identify("x.csv", "c-axis", axis="x"), "axis='x': c-axis has only one"),
        (lambda: hfc.load_scenario({"name": "a", "plant": {"name": "b"}}), ".*hfc.register"),
    ],
)
def test_a_mistake_of_a_script_names_its_argument(call, told):
    with pytest.raises(hfc.UserError, match=f"^{told}") as refused:
        call()
    assert "--" not in str(refused.value)


TWO = ["pd-only", "lin-lee-1999-table-2"]
WHOLE, NUMBER, SHARE = (
    "has to be a whole number",
    "has to be a number",
    "has to lie between 0 and 1",
)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: hfc.usable("pd-only", RAMP, machines=0), "machines=0: has to lie between 1 and"),
        (lambda: hfc.usable("pd-only", RAMP, machines=-3), "machines=-3: has to lie between 1"),
        (lambda: hfc.usable("pd-only", RAMP, machines="20"), f"machines='20': {WHOLE}"),
        (lambda: hfc.usable("pd-only", RAMP, spread=-1), f"spread=-1: {SHARE}"),
        (lambda: hfc.usable("pd-only", RAMP, seed=1.5), f"seed=1.5: {WHOLE}"),
        (lambda: hfc.compare(TWO, machines="20"), f"machines='20': {WHOLE}"),
        (lambda: hfc.compare(TWO, spread="a"), f"spread='a': {NUMBER}"),
        (lambda: hfc.compare(TWO, spread=float("nan")), "spread=nan: has to be a finite number"),
        (lambda: hfc.compare(TWO, seed=-1), "seed=-1: has to be 0 or more"),
        (
            lambda: hfc.compare(TWO, tolerances={"backlash": 5}),
            f"tolerances={{'backlash': 5}}: {SHARE}",
        ),
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, True), f"samples=True: {WHOLE}"),
        (lambda: hfc.robustness("pd-only", RAMP, 0.2, 5, tolerances=5), "an int is no table of"),
        (lambda: hfc.batch("x.toml", workers=2.0), f"workers=2.0: {WHOLE}"),
        (lambda: hfc.pick("x", "3"), f"point='3': {WHOLE}"),
        (lambda: hfc.identify("x.csv", "c-axis", bandwidth="5"), f"bandwidth='5': {NUMBER}"),
        (
            lambda: hfc.identify("x.csv", "c-axis", bandwidth=-5.0),
            r"bandwidth=-5.0: has to be greater than 0",
        ),
        (
            lambda: hfc.identify("x.csv", "c-axis", sample_time=0),
            "sample_time=0: has to be greater",
        ),
        (lambda: hfc.identify("x.csv", "c-axis", seed=None), f"seed=None: {WHOLE}"),
        (lambda: hfc.stability(gain="x"), f"gain='x': {NUMBER}"),
        (lambda: hfc.stability(time_constant=0), "time_constant=0: has to be greater than 0"),
        (lambda: hfc.import_("x.fis", sample_time="x"), f"sample_time='x': {NUMBER}"),
        (lambda: hfc.import_("x.fis", terms=(9, 50)), "terms=50: has to lie between 2 and 11"),
        (lambda: hfc.import_("x.fis", terms=7), "an int is no pair of numbers of terms"),
        (lambda: hfc.taught("pd-only", RAMP, lesson=5), "an int is no lesson"),
        (lambda: hfc.taught("pd-only", RAMP, lesson=Lesson(passes=1.5)), f"passes=1.5: {WHOLE}"),
        (lambda: hfc.taught("pd-only", RAMP, lesson=Lesson(rate="x")), f"rate='x': {NUMBER}"),
    ],
)
def test_a_number_that_is_none_is_a_line_and_no_traceback(call, told):
    with pytest.raises(hfc.UserError) as refused:
        call()
    assert str(refused.value).startswith(told)
    assert "\n" not in str(refused.value)
