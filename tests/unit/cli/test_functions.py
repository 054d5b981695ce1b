"""A command made from a function says what its source says, and nothing is left out silently."""

import ast
import inspect
import re

import click
import pytest

from hfc_design import api as hfc
from hfc_design.cli import functions, main
from hfc_design.cli.functions import function
from hfc_design.cli.names import NamedOption
from hfc_design.report.paper import for_a_paper

SOURCE = '''
def moved(path: str | Path, far: float = 2.5, names: Sequence[str] = (), *, on: bool = False):
    """Move a thing.

    Slowly.

    The counterpart of ``hfc move``. It returns nothing.

    Args:
        path: file, but not
            a folder.
        far: distance [m], more than ``names``.
        names: names, as "a"; default: all.
        on: go on.

    Raises:
        UserError: it cannot be moved.
    """
'''


@pytest.fixture
def read(monkeypatch, tmp_path):
    """Makes parameters of a function with this source."""

    def made(source, *body, **own):
        (tmp_path / "calls").mkdir(exist_ok=True)
        (tmp_path / "calls" / "moves.py").write_text(source)
        monkeypatch.setattr(functions, "__file__", str(tmp_path / "cli" / "functions.py"))
        return function("calls.moves.moved", *body, **own).make

    return made


def test_options_and_text_are_those_of_the_source(read):
    made = read(SOURCE)
    parameters = inspect.signature(made).parameters.values()
    path, far, names, on = (one.default.of(one.name, one.annotation) for one in parameters)
    assert made.__doc__ == "Slowly.\n\nPATH: file, but not a folder."
    assert (far.opts, far.type, far.default) == (["--far"], click.FLOAT, 2.5)
    assert far.help == "Distance [m], more than --names [default: 2.5]."
    assert names.multiple
    assert names.help == 'Names, as "a"; can be given several times [default: all].'
    assert on.is_flag
    assert on.help == "Go on."
    assert isinstance(path, click.Argument)
    assert path.required
    assert made(far=3.0).keywords == {"far": 3.0}


@pytest.mark.parametrize(
    ("old", "new", "body", "own", "told"),
    [
        ("far: float", "far: Motion", (), {}, "far"),  # a type without an option
        ("        on: go on.\n", "", (), {}, "on"),  # without a meaning
        ("", "", ("away",), {}, "away"),  # the function has no such parameter
        ("", "", (), {"gone": functions.option(None)}, "gone"),
    ],
)
def test_a_parameter_without_counterpart_is_a_fault(read, old, new, body, own, told):
    with pytest.raises(TypeError, match=f"calls.moves.moved: {told}: "):
        read(SOURCE.replace(old, new), *body, **own)


CALLED = [hfc.identify, hfc.frequency, hfc.experiment, hfc.check, hfc.stability, hfc.circle]


@pytest.mark.parametrize("called", [*CALLED, hfc.compare, for_a_paper])
def test_the_source_is_that_of_the_imported_function(called):
    source = functions._read(called.__module__.removeprefix("hfc_design."), called.__name__)
    assert inspect.getdoc(called) == ast.get_docstring(source)
    args = source.args
    every = [*args.args, *filter(None, [args.vararg]), *args.kwonlyargs]
    assert [*inspect.signature(called).parameters] == [one.arg for one in every]


@pytest.mark.parametrize("command", main.commands.values(), ids=list(main.commands))
def test_every_option_has_a_help_that_ends_its_sentence(command):
    """And tells its default, unless that is nothing."""
    for one in command.params:
        if isinstance(one, NamedOption):
            assert re.fullmatch(r'[A-Z"].*[^.]\.', one.help), one.opts
            if isinstance(one.default, int | float | str) and not one.is_flag:
                assert "[default: " in one.help or one.default == "", one.opts
