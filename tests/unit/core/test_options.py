"""A message names an option as its reader does: --samples 0, or samples=0 in a script."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import hfc_design
import hfc_design.api as hfc
from hfc_design.cli import main
from hfc_design.controllers.neural.record import Lesson
from hfc_design.core.records import BEGIN, END, OR, either, option
from hfc_design.formats.reading import Wish

FOLDER = Path(hfc_design.__file__).parent
NAMING = {"option", "check_whole", "check_number", "check_positive", "check_share"}
#: Options that no function has as an argument, and of other programs.
OF_SHELLS = {"parquet", "scheduler", "shared", "tls-ca", "tls-cert", "tls-key", "use"}
OF_SHELLS |= {"build-id", "xla_backend_extra_options", "ab", "ba"}
#: Texts that only a terminal shows.
ADVICE = {"--plant", "--sample-time", "; more terms, --terms up to x, usually reduce this"}
ADVICE |= {"identify it too (--free stiction_rise,...), from a log with slow reversals"}


def trees():
    """Every module that a script may use."""
    for path in sorted(FOLDER.rglob("*.py")):
        if "cli" not in path.parts and path.name != "records.py":
            yield path, ast.parse(path.read_text())


def calls(tree, names):
    """Every call of functions with these names."""
    return [x for x in ast.walk(tree) if getattr(getattr(x, "func", None), "id", "") in names]


def texts(tree):
    """Every text that is not for ``either`` reader, holes of a template as x."""
    told = {id(x) for one in ast.walk(tree) for x in getattr(one, "values", ())}
    told |= {id(x.value) for x in ast.walk(tree) if isinstance(x, ast.Expr)}
    told |= {id(x) for call in calls(tree, {"either"}) for x in ast.walk(call)}
    for one in (x for x in ast.walk(tree) if id(x) not in told):
        if isinstance(one, ast.JoinedStr):
            yield "".join(x.value if isinstance(x, ast.Constant) else "x" for x in one.values)
        elif isinstance(getattr(one, "value", None), str):
            yield one.value


def arguments():
    """Every argument that a function of the API has, or a method."""
    found = {*Wish._fields, *Lesson._fields, "sample", "share"}  # explain(design, *samples)
    for name in hfc.__all__:
        if inspect.isroutine(thing := getattr(hfc, name)):
            found |= {*inspect.signature(thing).parameters}
    return found | {*inspect.signature(hfc.Scenario.motion).parameters}


def test_no_text_leaves_a_script_with_an_option():
    for path, text in ((path, text) for path, tree in trees() for text in texts(tree)):
        left = re.sub(r"\bhfc [a-z]+ .*", "", "" if text in ADVICE else text)
        assert {*re.findall(r"(?<![\w-])--([a-z][\w-]*)", left)} <= OF_SHELLS, (path, text)


def test_options_and_arguments_that_messages_name_exist():
    there, options = arguments(), {"--share"}
    for command in main.commands.values():
        options |= {name for one in command.params for name in one.opts}
    every = [(path, call) for path, tree in trees() for call in calls(tree, NAMING)]
    for path, call in every:
        name, *others = (getattr(x, "value", None) for x in call.args)
        named = {one.arg: getattr(one.value, "value", None) for one in call.keywords}
        third = others[1] if others[1:] and isinstance(others[1], str) else name
        if isinstance(name, str):
            assert f"--{name.replace('_', '-')}" in options, (path, name)
            assert named.get("argument", third) in there, (path, name)
    assert len(every) > 60


@pytest.mark.parametrize(
    ("line", "typed", "told"),
    [
        (f"{option('samples', 0)}: must lie", "--samples 0: must lie", "samples=0: must lie"),
        (option("sample_time", 2.5), "--sample-time 2.5", "sample_time=2.5"),
        (option("out", "a b", "folder"), "--out a b", "folder='a b'"),
        (option("set", 5, "changes", "a.b"), "--set a.b=5", "changes={'a.b': 5}"),
        (option("at", argument="sample", key="x"), "--at x", "sample: x"),
        (f"{option('axis')}: is missing", "--axis: is missing", "axis: is missing"),
        (f"fewer with {option('free', ...)}", "fewer with --free", "fewer with free="),
        (f"add {option('anyway', True)}", "add --anyway", "add anyway=True"),
        (f"{either('--memory or ', '')}HFC", "--memory or HFC", "HFC"),
        ("run hfc pick run --point 3 --out a",) * 3,
        # What a user has typed is no part of the text.
        (option("axis", f"a{OR}b{END}c"), "--axis a?b?c", "axis='a\\ufdd1b\\ufdd2c'"),
        (f"{BEGIN}a: {option('axis')}", "?a: --axis", "?a: axis"),
    ],
)
def test_a_line_for_either_reader(line, typed, told):
    error = hfc.UserError(line)
    assert (error.lines, str(error)) == ([typed], told)
    again = hfc.UserError(f"{error.message}, here").within("x.toml")
    assert (again.typed, str(again)) == (f"x.toml: {typed}, here", f"x.toml: {told}, here")
