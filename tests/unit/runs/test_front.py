"""The front of a run: its file, its report, the designs of its points."""

import pytest
from run_folders import hfc


def refusal(*arguments):
    done = hfc(*arguments)
    assert done.exit_code == 2, done.output
    (line,) = done.stderr.splitlines()
    return line


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["tracking"], "--pareto tracking: has to be two or three objectives, not 1"),
        (["tracking,speed"], "speed: is no objective; there is tracking, effort, units"),
        (["a,b,c,d"], "a: is no objective"),
        (["tracking,effort,iae,chatter"], "has to be two or three objectives, not 4"),
        (["tracking,effort", "--preset", "race"], "race finds one design and no front; nsga-ii"),
        (
            ["tracking,effort", "--set", "search.preset=lin-lee-1999"],
            "strategy lin-lee-1999 finds one design and no front",
        ),
        (["tracking,units", "--controller", "pd"], "has no hierarchy whose units"),
    ],
)
def test_what_cannot_be_traded_is_told_in_a_line(arguments, why, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert why in refusal("design", "c-axis-ramp", "--pareto", *arguments)
    assert not [*tmp_path.iterdir()]
