"""Messages are written in the words of the command line; a script reads its own arguments."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import hfc_design
import hfc_design.api as hfc
from hfc_design.controllers.neural.record import Lesson
from hfc_design.core.for_scripts import ARGUMENTS, FLAGS, for_scripts
from hfc_design.formats.reading import Wish

FOLDER = Path(hfc_design.__file__).parent
#: Options of messages that only the command line can cause, or of other programs.
OF_SHELLS = {"lookup", "parquet", "scheduler", "shared", "tls-ca", "tls-cert", "tls-key"}
OF_SHELLS |= {"build-id", "pareto", "use", "ab", "ba"}


def texts():
    """Every text of the package with an option in it, holes of a template as X."""
    for path in sorted(FOLDER.rglob("*.py")):
        if path.is_relative_to(FOLDER / "cli") or "--" not in (source := path.read_text()):
            continue
        tree = ast.parse(source)
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
        ("--samples 0: must lie", "samples=0: must lie"),
        ("--plant mine: is for", "plant='mine': is for"),
        ("--set a.b=5: a is not a table", "changes={'a.b': 5}: a is not a table"),
        ("x.csv: look for fewer with --free", "x.csv: look for fewer with free="),
        ("replay it with --open-loop", "replay it with bandwidth=0"),
        ("to continue add --anyway", "to continue add anyway=True"),
        ("own by --use module:OBJECT", "own by hfc.register(module.OBJECT)"),
        ("none; run hfc pick run --point 3 --out a",) * 2,
        ("--scheduler here: no answer",) * 2,
        ("a--set of -- things",) * 2,
    ],
)
def test_a_line_in_the_words_of_a_script(typed, told):
    error = hfc.UserError(typed)
    assert (str(error), error.lines) == (told, [typed])
