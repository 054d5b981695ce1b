"""What cannot be asked of ``hfc report`` is refused in a line, and nothing is written."""

from pathlib import Path

import pytest
from report_pages import NAME
from wording import refused_command


@pytest.mark.parametrize(
    ("arguments", "where"),
    [
        ((NAME, "--each"), NAME),
        ((".", "--out", "x.html"), "--out x.html"),
        ((NAME, "--width", "88mm"), "--width"),
        ((NAME, "--figures", "png"), "--figures png"),
        ((NAME, "--figures", "pdf", "--width", "3mm"), "--width"),
    ],
    ids=["each", "folder", "width", "png", "narrow"],
)
def test_what_does_not_go_together_is_a_line(arguments, where, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = refused_command("report", *arguments)
    assert found.where == where
    assert found.count("\n") == 1
    assert not list(Path().iterdir())
