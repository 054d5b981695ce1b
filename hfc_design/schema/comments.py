"""Meanings that are read from the code: comments at fields, with units, and docstrings.

A comment stands behind a field, or in lines of ``#:`` before it::

    mass: float = 95.11  # of everything that moves [kg]
"""

import ast
import inspect
import io
import re
import tokenize
from functools import cache
from textwrap import dedent
from typing import Any, NamedTuple

#: Python's default docstring of a field of a NamedTuple.
SAYS_NOTHING = "Alias for field"
UNIT = re.compile(r"\s*\[([^\[\]]+)\](?=$|[;,])")


class Comment(NamedTuple):
    """Parsed comment of a field."""

    meaning: str = ""
    unit: str = ""  # "1" for none; "" if it has no brackets


def said(text: str) -> Comment:
    """Return a parsed comment; its unit is in the last brackets before its end, "," or ";"."""
    text = " ".join(text.split()).replace("``", "")
    brackets = [*UNIT.finditer(text)]
    if not brackets:
        return Comment(text)
    last = brackets[-1]
    meaning = (text[: last.start()] + text[last.end() :]).strip(" ;,")
    return Comment(meaning, last[1])


def comments_of(record: type[Any]) -> dict[str, Comment]:
    """Return field -> comment of a record or NamedTuple; comments of base classes are inherited."""
    comments: dict[str, Comment] = {}
    for base in reversed(record.__mro__):
        if base.__module__.partition(".")[0] not in ("builtins", "pydantic"):
            comments |= _in_source(base)
    for name in getattr(record, "_fields", ()):  # a class that a function made has docstrings
        text = getattr(record, name).__doc__ or ""
        if not text.startswith(SAYS_NOTHING):
            comments.setdefault(name, said(text))
    return comments


@cache
def _in_source(record: type[Any]) -> dict[str, Comment]:
    """Return field -> comment in the source text of the class itself."""
    try:
        text = dedent(inspect.getsource(record))
    except (OSError, TypeError):  # built in, typed at a prompt, or made by a function
        return {}
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    comments = {token.start[0]: token.string for token in tokens if token.type == tokenize.COMMENT}
    lines, by_field = text.splitlines(), dict[str, Comment]()
    whole: Any = ast.parse(text).body[0]
    for field in whole.body:
        if not (isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)):
            continue
        above: list[str] = []
        k = field.lineno - 1
        while k in comments and lines[k - 1].lstrip().startswith("#"):
            above.insert(0, comments[k].lstrip("#: "))
            k -= 1
        if comment := comments.get(field.end_lineno or 0, "").lstrip("# ") or " ".join(above):
            by_field[field.target.id] = said(comment)
    return by_field


#: Citation key of a paper -> its authors and year.
PAPERS = {
    "LL": "Lin & Lee 1999",
    "JK95": "Jee & Koren 1995",
    "JK04": "Jee & Koren 2004",
    "LG09": "Lin & Gai 2009",
    "EMPS": "Janot, Gautier & Brunot 2019",
}
_PLACE = r"(?:eq\.|[Tt]able|sections?|[Aa]ppendix|fig\.) ?[A-Z\d][\d.]*"
_CITED = rf"(?:{'|'.join(PAPERS)})\b"
_NAMED = r"(?:Lin & Lee|Lin & Gai|Jee & Koren|Koren) \(?\d{4}\)?|Huang & Shy|Huang et al\."
#: A citation of a paper, "LL eq. 1-2" or "Lin & Lee 1999, section 3.2".
_SOURCE = re.compile(rf"\b(?:{_CITED}|{_NAMED})(?:,? {_PLACE}(?:(?:-| to | and )\d[\d.]*)?)?")


def first_line(text: str) -> str:
    """Return the first paragraph of a docstring on one line, without backquotes and final dot."""
    return " ".join(text.partition("\n\n")[0].split()).replace("`", "").rstrip(".")


def described(text: str) -> str:
    """Return the ``first_line`` of a docstring without the citation in brackets."""
    return re.sub(r" \([^()]*(cited as|\d{4})[^()]*\)", "", first_line(text))


def source_in(text: str) -> str:
    """Return the paper that a text cites, with the equation if given; "" if it cites none."""
    text = re.sub(r"cited as (\w+), eq", r"\1 eq", " ".join(text.split()))
    sources = [re.sub(r"(?<=[\d)])[., ]+$", "", one[0]) for one in _SOURCE.finditer(text)]
    placed = [one for one in sources if re.search(_PLACE, one)]
    first = next(iter(placed or sources), "").replace("(", "").replace(")", "")
    for short, paper in PAPERS.items():
        if first == short or first.startswith((f"{short} ", f"{short},")):
            first = ", ".join(filter(None, (paper, first.removeprefix(short).strip(", "))))
    return first
