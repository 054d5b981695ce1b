"""Parameters of commands from the functions that they call, whose docstrings alone explain them.

Their sources are read, because an import takes seconds.
"""

import ast
import re
from functools import partial
from importlib import import_module
from inspect import Parameter, Signature
from pathlib import Path
from typing import Any

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import Answer, Texts, Together, argument, option
from hfc_design.cli.names import DESIGN, PLANT, SCENARIO


def names(text: str) -> list[str]:
    """Return the names in a text as a,b."""
    return [one.strip() for one in text.split(",")]


AGAIN = "; can be given several times"
#: Annotation in a source -> type on a command line, click's type, more about the option.
TYPES: dict[str, tuple[Any, Any, str]] = {
    **{x.__name__: (x, None, "") for x in (bool, float, int, str)},
    **dict.fromkeys(("Changes", "Mapping[str, float]", "Sequence[str]"), (Texts, None, AGAIN)),
    "str | Path": (Path, None, ""),
    "AnyDesign": (str, DESIGN, ""),
    "AnyScenario": (str, SCENARIO, ""),
    "Sequence[float]": (Texts, click.FLOAT, AGAIN),
    "Sequence[str] | None": (str, click.types.FuncParamType(names), "; several as a,b"),
}
#: Parameters that have the same option in every command.
SHARED = {
    "changes": common.SETTING,
    "columns": option(None, "--column", metavar="NAME=COLUMN"),
    "plant": option("NAMES, or your own as module:OBJECT.", kind=PLANT),
}
#: An entry of the Args of a docstring.
ENTRY = re.compile(r"^    (\w+): (.*(?:\n {8}.*)*)", re.MULTILINE)


def _read(module: str, name: str) -> Any:
    """Return the tree of a function without its body, as parsing whole modules takes longer."""
    place = Path(__file__).parents[1].joinpath(*module.split(".")).with_suffix(".py")
    _, begin, rest = place.read_text("utf-8").partition(f"\ndef {name}(")
    head, end, _ = rest.partition('\n    """\n')
    tree: Any = ast.parse(f"{begin}{head}{end}")
    return tree.body[0]


def function(path: str, *body: str, **own: Any) -> Any:
    """Return the default of a parameter: the function MODULE.NAME with values of a command line.

    Its parameters become options, or arguments if they have no default, except those that the
    ``body`` of the command passes. ``own`` are those of which a command line says more. The help
    of the command is the docstring up to "The counterpart of", and the meanings of arguments.

    Raises:
        TypeError: a parameter has no meaning in ``Args``, no option for its type, or is unknown.
    """
    module, _, called = path.rpartition(".")
    source = _read(module, called)
    text, _, rest = str(ast.get_docstring(source)).partition("\n\nArgs:\n")
    text = text.partition("\n\nThe counterpart of ")[0].partition("\n\n")[2]
    meanings = dict(ENTRY.findall(rest.partition("\n\n")[0]))
    words = {name: f"--{name.replace('_', '-')}" for name in meanings}
    words |= {name: one.names[0] for name, one in (SHARED | own).items() if one.names}
    plain = partial(re.sub, "``(.*?)``", lambda word: words.get(word[1], word[1]))
    args, shown = source.args, []
    every = [*args.args, *args.kwonlyargs]
    if unknown := {*body, *own} - {one.arg for one in every}:
        raise TypeError(f"{path}: {', '.join(unknown)}: no such parameters")
    defaults = [None] * (len(args.args) - len(args.defaults)) + [*args.defaults, *args.kw_defaults]
    for one, default in zip(every, defaults, strict=True):
        if (name := one.arg) in body:
            continue
        known = own.get(name, SHARED.get(name)) or (option(None) if default else argument())
        annotation = ast.unparse(one.annotation or one).strip("'")
        if annotation not in TYPES:
            annotation = annotation.removesuffix(" | None")
        if name not in meanings or annotation not in TYPES:
            raise TypeError(f"{path}: {name}: must be explained, of a type with an option")
        kind, clicks, more = TYPES[annotation]
        meaning = plain(" ".join(meanings[name].split()))
        settings = dict(known.settings)
        if known.make is click.Argument:
            text += f"\n\n{name.upper()}: {meaning}"
        else:
            if default and kind not in (bool, Texts):
                settings.setdefault("default", ast.literal_eval(default))
            settings["help"] = settings["help"] or _help(meaning, more, settings.get("default"))
        known = known._replace(kind=known.kind or clicks, settings=settings)
        shown.append(Parameter(name, Parameter.KEYWORD_ONLY, default=known, annotation=kind))

    def make(**given: Any) -> partial[Any]:
        return partial(_late, module, called, **given)

    make.__doc__ = plain(text)
    make.__signature__ = Signature(shown)  # type: ignore[attr-defined]
    return Together(make)


def _late(module: str, name: str, *others: Any, **given: Any) -> Any:
    return getattr(import_module(f"hfc_design.{module}"), name)(*others, **given)


def _help(meaning: str, more: str, default: Any) -> str:
    """Return the help of an option, with its default in brackets."""
    text, _, usual = meaning.rstrip(".").partition("; default: ")
    if not usual and default not in (None, "", ()):
        usual = f"{default:g}" if isinstance(default, float) else str(default)
    return text[0].upper() + text[1:] + more + (f" [default: {usual}]." if usual else ".")


def drawn(result: Any, plot: Path | None = None) -> Answer:
    """Return the answer of a command on a result, after drawing it into a file."""
    if plot is not None:
        from hfc_design.plotting.files import save

        save(result.figure(), plot)
    return Answer(result.numbers(), result.tables, [plot] if plot else [])
