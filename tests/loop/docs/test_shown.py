"""What the pages say that a command prints, it prints."""

import re
import shlex

import pytest
from doc_pages import ROOT
from run_folders import hfc

DOCS = ROOT / "docs"
MESSAGES = re.findall(
    r"^\| `(hfc [^`]*)` \| `([^`]*)` \|", (DOCS / "questions.md").read_text("utf-8"), re.MULTILINE
)


@pytest.mark.parametrize(("command", "says"), MESSAGES, ids=[one[1] for one in MESSAGES])
def test_messages_are_those_of_the_program(command, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = hfc(*shlex.split(command)[1:])
    assert done.exit_code in (1, 2)
    assert len(done.stderr.splitlines()) == 1
    assert says in done.stderr


def test_the_table_of_errors_is_read():
    assert len(MESSAGES) == 10
