"""What a terminal of any width shows: the time left to the last, and numbers that nobody cut."""

import io
import re
import time

import pytest
from rich.console import Console

from hfc_design.core import console
from hfc_design.core.console import ProgressBar, busy, show
from hfc_design.core.tables import Table
from hfc_design.core.wording import percent

WIDTHS = 40, 60, 80, 120
LINE = "best 380.57  median 371.2  diverged 3  structures 17  1.2e+07 individual-steps/s"
#: As long as a number of a table may become.
NUMBERS = ("-0.00080823", "1.2346e-05", "123456.789", "-0.12345678", "12", "0.33333333")


@pytest.fixture
def at(monkeypatch):
    """A terminal of a width, and what it shows."""

    def made(width, terminal=True):
        shown = io.StringIO()
        own = Console(width=width, file=shown, force_terminal=terminal, color_system=None)
        monkeypatch.setattr(console, "terminal", lambda stderr=False: own)
        return shown

    return made


def line_of(bar):
    """The line of a progress bar as it is now."""
    (task,) = bar._bar.tasks
    return bar._bar.columns[0].render(task).plain


@pytest.mark.parametrize("width", WIDTHS)
def test_the_time_left_stays_longest(at, width):
    at(width)
    with ProgressBar("generation", 300) as bar:
        bar.show(completed=10, line=LINE)
        time.sleep(0.02)
        bar.show(completed=120, line=LINE)
        line = line_of(bar)
    assert len(line) < width
    assert re.match(r"generation 120/300  .*\b\d+:\d\d:\d\d left$", line)
    assert ("━" in line, "best 380.57" in line) == (width >= 60, width >= 60)
    told = [part for part in LINE.split("  ") if part in line]
    assert told == LINE.split("  ")[: len(told)]  # the most important ones first
    assert len(told) == {40: 0, 60: 1, 80: 2, 120: 4}[width]


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("terminal", [True, False])
def test_numbers_of_a_table_are_never_cut(at, capsys, width, terminal):
    shown = at(width, terminal)
    head = ["metric", *(f"design {name}" for name in NUMBERS)]
    rows = [[f"metric_{row}_of_a_loop", *NUMBERS] for row in range(3)]
    show(Table("caption in as much room as there is", head, rows, lines=["a line ±1 µm"]))
    said = capsys.readouterr().out
    text = shown.getvalue()
    assert "…" not in text
    assert max(map(len, text.splitlines())) <= width
    for number in NUMBERS:
        assert len(re.findall(rf"(?<![\w.]){re.escape(number)}(?![\w.])", text)) == 4
    assert " ".join(said.split()) == "caption in as much room as there is a line +-1 um"
    tables = text.count("metric\n") or len(re.findall(r"^metric\b", text, re.MULTILINE))
    assert (tables > 1) == (width < 100)


def test_what_has_no_steps_says_that_it_works_on_a_terminal_alone(capsys, monkeypatch):
    with busy("thinking"):
        print("found")
    assert capsys.readouterr() == ("found\n", "")
    monkeypatch.setenv("FORCE_COLOR", "1")  # which is how rich is told of a terminal
    with busy("thinking"):
        print("found")
    told = capsys.readouterr()
    assert told.out == "found\n"
    assert "thinking" in told.err


@pytest.mark.parametrize(
    ("share", "told"),
    [
        (0.0, "0 %"),
        (5e-34, "less than 0.001 %"),
        (1.234e-4, "0.012 %"),
        (0.9951, "100 %"),
        (3.4, "340 %"),
    ],
)
def test_no_share_has_an_exponent(share, told):
    assert percent(share) == told


def test_a_terminal_of_no_columns_has_the_usual_ones(monkeypatch):
    monkeypatch.setenv("COLUMNS", "0")
    assert console.room() == 80
    monkeypatch.setenv("COLUMNS", "40")
    assert console.room() == 40


def test_a_title_stands_for_the_caption_and_the_best_are_marked(at, capsys):
    shown = at(80)
    rows = [["a", "1–2", "never"], ["b", "–", "3"]]
    show(Table("caption", ["metric", "one", "two"], rows, [[1], []], "title"))
    assert [line.split() for line in shown.getvalue().splitlines()[2:]] == [
        ["a", "1-2", "*", "never"],
        ["b", "-", "3"],
    ]
    assert capsys.readouterr().out == "title\n"
