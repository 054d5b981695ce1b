"""Whether what a user is told is in plain words, a bounded line a fault."""

import re

from pydantic_core._pydantic_core import list_all_errors  # its own list of all that it says

from hfc_design.core.validation_errors import MOST

#: Every sentence of the library that checks records, with room for what it puts into them.
SENTENCES = [
    re.compile(".*".join(map(re.escape, re.split(r"\{\w+\}", one["message_template_python"]))))
    for one in list_all_errors()
    if len(re.sub(r"\{\w+\}|\W", "", one["message_template_python"])) > 8
]
#: What it says beside these, and what only programmers know.
OTHERS = ("Value error", "Assertion failed", "[type=", "pydantic", "more)", "Error:", "<class ")


def library_words(line: str) -> str:
    """What a line has from the library; "" for nothing."""
    found = (sentence.search(line) for sentence in SENTENCES)
    said = [match[0] for match in found if match] + [one for one in OTHERS if one in line]
    return said[0] if said else ""


def plain_lines(error: Exception, start: str = "", written: str = "") -> list[str]:
    """The lines of a UserError, each bounded, printable and in words of this project.

    They may quote what the user has ``written``, whatever words it has.
    """
    lines = str(error).split("\n")
    for line in lines:
        assert line.startswith(start)
        assert line.isprintable()
        assert len(line) <= 295
        assert library_words(line) in written, line
    assert len(lines) <= MOST + 1
    return lines
