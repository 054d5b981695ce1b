"""Tables in LaTeX, read by a small reader of TeX."""

import re

import pytest
import tex
from hypothesis import given
from hypothesis import strategies as st

from hfc_design.core.tables import Table
from hfc_design.plotting.latex import escaped, latex

#: Letters that TeX takes for something else, and others.
LETTERS = st.text(r"\{}$&#%_^~<>|`'-,[]*aZ0.éλφγΩ≤∞")
HOSTILE = r"\input{/etc/passwd}%$x_1^2$ & ~#{"


@given(LETTERS)
def test_what_is_escaped_is_printed_as_it_is(text):
    told = escaped(text)
    assert tex.depth(told) == (0, 0)
    assert tex.printed(told) == text.strip()
    assert "--" not in told  # of which TeX makes one dash
    assert not set(tex.tokens(told)) & {"#", "&", "^", "_", "~", "%"}


def test_what_stands_below_and_above_the_line():
    """Two digits below are one index; of a unit the powers are above, of a name nothing is."""
    assert escaped("A₁₂ of 3") == "A$_{12}$ of 3"
    head = ["m2 [V2 s]", "rad/s2", "a [mm3/s2]", "[b2_x3]"]
    text = latex("x", Table("c", head, [["a2 [1e2]", *"123"]]))
    assert r"m2 [V$^2$ s] & rad/s2 & a [mm$^3$/s$^2$] & [b2\_x3]" in text
    assert "a2 [1e2] & 1" in text
    gains = latex("x", Table("c", ["gain", "value", "unit"], [["k2", "1.5", "A/(mm/s2)"]]))
    assert r"k2 & 1.5 & A/(mm/s$^2$) \\" in gains


def test_every_row_has_the_cells_of_the_head():
    head = ["metric [%]", "a", HOSTILE]
    cells = [["[x]", "1.5", HOSTILE], ["*", "-2", "b"], ["c", "–", "–1"]]
    text = latex("name", Table(f"100 % of {HOSTILE}", head, cells))
    found = tex.rows(text)
    assert found[0] == head
    assert found[1:] == [[cell.replace("-2", "\u22122") for cell in row] for row in cells]
    assert r"\label{tab:name}" in text
    caption = re.search(r"\\caption\{(.*)\}\n", text)[1]
    assert tex.printed(caption) == f"100 % of {HOSTILE}"
    # Behind the end of a row TeX takes a bracket or a star for an option of it.
    assert not re.search(r"\\\\\s*[\[*]|rule\s*[\[*]", text)


@pytest.mark.parametrize(
    ("cell", "told"),
    [
        ("4.83e-05", "4.83×10^−5"),
        ("-1.5e+03", "−1500"),
        ("1e-05 to 2e-05", "1×10^−5 to 2×10^−5"),
        ("0.203 / 2.48e+10", "0.203 / 2.48×10^10"),
        ("10358026.8", "1.036×10^7"),
        ("4294967295", "4294967295"),  # a seed
        ("< 0.0001", "< 0.0001"),
        ("94.3–99.2", "94.3–99.2"),
        ("∞", "∞"),
    ],
)
def test_numbers_have_few_digits(cell, told):
    text = latex("x", Table("c", ["name 1e-05", "value"], [["run 1e-05", cell]]))
    assert r"\begin{tabular}{lr}" in text
    (name, value) = tex.rows(text)[1]
    assert name == "run 1e-05"  # a name stays what it is
    assert value.replace(" ", "") == told.replace(" ", "")


def test_the_best_are_bold_and_a_table_says_whose_it_is():
    rows = [["a", "1.5", "2"], ["b", "3", "4"]]
    listing = Table("Medians.", ["metric", "x", "y"], rows, [[1], []])
    text = latex("groups", listing, "100 %_of runs", "100-of-runs")
    assert [line for line in text.splitlines() if "textbf" in line] == [r"a & \textbf{1.5} & 2 \\"]
    assert r"\label{tab:100-of-runs-groups}" in text
    assert tex.printed(re.search(r"\\caption\{(.*)\}\n", text)[1]) == "100 %_of runs: Medians."
    assert "wide" not in text
