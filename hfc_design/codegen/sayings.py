"""Names and comments of generated code, taken from the functions of a law."""

import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from inspect import CO_VARARGS, CO_VARKEYWORDS
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from hfc_design.codegen.nodes import INNER, Comment, Node, Stored, Tape

#: Citation of a source: a first paragraph of a docstring that has one becomes a comment.
CITES = re.compile(r"\b(eq|fig)\. |\b(Table|Appendix|section|equation) \w", re.IGNORECASE)
#: Folders and files of the package and of Python whose functions give no names and comments.
SKIPPED = (
    *INNER,
    *(
        str(Path(os.__file__).with_name(name))
        for name in ("abc.py", "contextlib.py", "functools.py", "inspect.py", "typing.py")
    ),
)
#: Longest tuple or list whose numbers get names with an index.
FEW = 8


@contextmanager
def named(trace: Tape) -> Iterator[None]:
    """Take names and comments for the code from a law that runs inside this context.

    Nodes and arrays get the names of local variables of the law's functions. The first paragraph of
    a docstring that cites a source becomes a comment before the function's statements.
    """

    def watch(frame: FrameType, event: str, argument: Any) -> None:
        code = frame.f_code
        if code.co_filename.startswith(SKIPPED):
            return
        if event == "call" and CITES.search(line := first_line(code)):
            block = trace.running.block
            block.items.append(Comment(line))
        if event == "return":
            count = code.co_argcount + code.co_kwonlyargcount
            count += bool(code.co_flags & CO_VARARGS) + bool(code.co_flags & CO_VARKEYWORDS)
            given = code.co_varnames[:count]
            local_names = (
                *code.co_varnames[count:],
                *(x for x in code.co_cellvars if x not in given),
            )
            for name in local_names:
                call_it(frame.f_locals.get(name), name)

    with profiled(watch):
        yield


@contextmanager
def profiled(watch: Callable[[FrameType, str, Any], None] | None) -> Iterator[None]:
    """Call ``watch`` for the functions that run inside this context; None: take no names there."""
    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        yield
    finally:
        sys.setprofile(before)


def first_line(code: CodeType) -> str:
    """Return what a function returns: its docstring's first paragraph, no markup; "" if none."""
    docstring = code.co_consts[0] if code.co_consts else None
    if not isinstance(docstring, str) or code.co_name.startswith("<"):
        return ""
    text = " ".join(docstring.strip().split("\n\n")[0].replace("``", "").split())
    what = re.sub(r"^Return (the |an? )?", "", text)
    return what[:1].upper() + what[1:]


def call_it(value: Any, name: str) -> None:
    """Give a name to a value that has none yet."""
    if isinstance(value, Node):
        value.name = value.name or name
    elif isinstance(value, Stored):
        value.storage.name = value.storage.name or name
    elif isinstance(value, tuple | list) and len(value) <= FEW:
        for k, one in enumerate(value):
            if isinstance(one, Node | Stored):
                call_it(one, f"{name}_{k}")
