"""The comments beside the fields of a record: what each means, and its unit in brackets.

A comment stands behind a field, or in lines of ``#:`` before it::

    mass: float = 95.11  # of everything that moves [kg]
"""

import ast
import inspect
import io
import re
import tokenize
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

#: What Python says of a field of a NamedTuple of which nobody says anything.
SAYS_NOTHING = "Alias for field"
UNIT = re.compile(r"\s*\[([^\[\]]+)\](?=$|[;,])")


class Comment(NamedTuple):
    """What a comment says."""

    meaning: str = ""
    unit: str = ""  # "1" for none; "" if it has no brackets


def said(text: str) -> Comment:
    """A comment apart: the last brackets before its end or before a remark hold the unit."""
    text = " ".join(text.split()).replace("``", "")
    found = [*UNIT.finditer(text)]
    if not found:
        return Comment(text)
    last = found[-1]
    meaning = (text[: last.start()] + text[last.end() :]).strip(" ;,")
    return Comment(meaning, last[1])


def comments_of(record: type[Any]) -> dict[str, Comment]:
    """Field -> comment of a record or a NamedTuple, those of its bases where it has none itself."""
    found: dict[str, Comment] = {}
    for one in reversed(record.__mro__):
        if one.__module__.partition(".")[0] not in ("builtins", "pydantic"):
            found |= _own(one)
    for name in getattr(record, "_fields", ()):  # of one that was made by a function
        told = getattr(record, name).__doc__ or ""
        if name not in found and not told.startswith(SAYS_NOTHING):
            found[name] = said(told)
    return found


@cache
def _own(record: type[Any]) -> dict[str, Comment]:
    """Those that stand in the text of a class itself."""
    try:
        file = inspect.getsourcefile(record)
    except TypeError:  # built in, or typed in
        return {}
    if file is None or not Path(file).is_file():
        return {}
    classes, comments, alone = _read(file)
    found: dict[str, Comment] = {}
    for field in classes[record.__name__].body if record.__name__ in classes else ():
        if not (isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)):
            continue
        above: list[str] = []
        k = field.lineno - 1
        while k in alone:
            above.insert(0, comments[k].lstrip("#: "))
            k -= 1
        told = comments.get(field.end_lineno or 0, "").lstrip("# ") or " ".join(above)
        if told:
            found[field.target.id] = said(told)
    return found


@cache
def _read(file: str) -> tuple[dict[str, ast.ClassDef], dict[int, str], set[int]]:
    """The classes of a file by name, its comments by line, the lines that are nothing else."""
    text = Path(file).read_text("utf-8")
    nodes = ast.walk(ast.parse(text))
    classes = {node.name: node for node in nodes if isinstance(node, ast.ClassDef)}
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    comments = {token.start[0]: token.string for token in tokens if token.type == tokenize.COMMENT}
    alone = {k for k, line in enumerate(text.splitlines(), 1) if line.lstrip().startswith("#")}
    return classes, comments, alone & comments.keys()
