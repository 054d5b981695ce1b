"""What the pages say that a command prints, it prints."""

import re

from doc_pages import ROOT

DOCS = ROOT / "docs"
MESSAGES = re.findall(
    r"^\| `(hfc [^`]*)` \| `([^`]*)` \|", (DOCS / "questions.md").read_text("utf-8"), re.MULTILINE
)


def test_the_table_of_errors_is_read():
    assert len(MESSAGES) == 10
