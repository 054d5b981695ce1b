"""What cannot be traded."""

import pytest
from wording import refused_command


@pytest.mark.parametrize(
    "arguments",
    [
        ["tracking,speed"],
        ["tracking,effort", "--preset", "race"],
        ["tracking,effort", "--set", "search.preset=lin-lee-1999"],
        ["tracking,units", "--controller", "pd"],
    ],
)
def test_what_cannot_be_traded_is_told_in_a_line(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert refused_command("design", "c-axis-ramp", "--pareto", *arguments).count("\n") == 1
    assert not [*tmp_path.iterdir()]
