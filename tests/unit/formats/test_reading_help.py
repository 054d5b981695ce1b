"""What a reader says of files that it does not take: how they can be taken, and what they lack."""

import pytest
from click.testing import CliRunner
from imported_files import MAMDANI_FIS
from places import ROOT

from hfc_design.cli import main
from hfc_design.core.records import UserError
from hfc_design.formats.reading import Wish, imported

LESSON = (ROOT / "docs" / "lesson.fll").read_text()
SIGNALS = {"Position error": "error", "d/dt error": "error_change"}
FORGOTTEN = "  rule: if error is N and error_change is P then command is none\n"
HINT = "with terms=7 it is sampled into triangles"


def refused(path, text):
    path.write_text(text)
    with pytest.raises(UserError) as caught:
        imported(path, Wish())
    return str(caught.value)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("AlgebraicProduct", "Minimum"),
        ("Triangle -20.000 0.000 20.000", "Trapezoid -20 -5 5 20"),
        ("is N then command is back", "is N then command is back with 0.5"),
    ],
)
def test_what_can_be_sampled_is_told(tmp_path, old, new):
    path = tmp_path / "mine.fll"
    assert HINT in refused(path, LESSON.replace(old, new))
    assert imported(path, Wish(terms=(7, 7))).provenance["sampled"]["terms"] == "7 x 7"


@pytest.mark.parametrize(
    "text",
    [
        LESSON.replace(FORGOTTEN, ""),
        LESSON + FORGOTTEN.replace("none", "more"),
        LESSON.replace("command is back", "command is bakc"),
        LESSON.replace("WeightedAverage TakagiSugeno", "Nothing"),
    ],
)
def test_a_mistake_is_not_to_be_sampled(tmp_path, text):
    assert HINT not in refused(tmp_path / "mine.fll", text)


@pytest.mark.parametrize("quote", ["", '"'])
def test_a_fis_without_apostrophes(tmp_path, quote):
    text = MAMDANI_FIS.read_text().replace("'", quote)
    assert "names between apostrophes" in refused(tmp_path / "mine.fis", text)


@pytest.mark.parametrize(
    ("rules", "forgotten"),
    [
        ("", True),
        ("  rule: if error is N then command is none\n", False),
        ("  rule: if error is not Z and error_change is P then command is none\n", False),
        ("  rule: if error is P or error_change is Z then command is none\n", True),
    ],
)
def test_a_forgotten_rule_is_told(tmp_path, rules, forgotten):
    path = tmp_path / "mine.fll"
    text = LESSON.replace("disjunction: none", "disjunction: Maximum")
    path.write_text(text.replace(FORGOTTEN, rules))
    told = ["error is N and error_change is P"] if forgotten else []
    found = imported(path, Wish(terms=(3, 3))).provenance["sampled"]
    assert found.get("without_rule", []) == told
    arguments = ["import", str(path), "--terms", "3", "--out", str(tmp_path / "mine.json")]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0
    assert all(f"no rule for {pair}" in done.stderr for pair in told)
    assert ("warning" in done.stderr) == forgotten


@pytest.mark.parametrize("terms", [4, 5, 6, 7, 9, 11])
def test_what_says_the_opposite_on_the_other_side_still_does(terms):
    controller = imported(MAMDANI_FIS, Wish(signals=SIGNALS, terms=(terms, terms))).controller
    for side in (controller.error_terms, controller.error_change_terms):
        centres = [term.centre for term in side]
        assert centres == [-centre for centre in centres[::-1]]
    table = controller.rules.centroids
    for row, opposite in zip(table, table[::-1], strict=True):
        assert row == pytest.approx([-value for value in opposite[::-1]], abs=1e-12)
