"""Files that no design can hold are refused in one line with file and line."""

import pytest
from imported_files import (
    CHANGE,
    GAUSSIAN,
    MAMDANI_FIS,
    MAMDANI_FLL,
    MAMDANI_SIGNALS,
    TEXTS,
)
from places import ROOT
from wording import refused

from hfc_design.core.records import UserError
from hfc_design.formats.reading import Wish, imported

SECOND = "OutputVariable: w\n  defuzzifier: WeightedAverage\n"
#: (what stands in the text, what instead, line of the fault), of each text.
FLL = [
    ("defuzzifier: WeightedAverage", "defuzzifier: Tsukamoto", 25),
    ("defuzzifier: WeightedAverage", "defuzzifier: Centroid 100", 26),
    ("  defuzzifier: WeightedAverage\n", "", 23),
    ("conjunction: AlgebraicProduct", "conjunction: Minimum", 76),
    ("d0 Ramp -6.3", "d0 Triangle -13 -9.5 -6.3 #", 7),
    ("range: -12.000 12.000", "range: twelve", 5),
    ("  range: -40 40", "  lock-previous: true", 24),
    ("  range: -40 40", "  lock-range: true\n  range: -1 1", 24),
    ("d3 Triangle", "d3 Bell", 6),
    ("d3 Triangle -0.9 0.25 1.7 1.0", "d3 Triangle -0.9 0.25 1.7 0.5", 6),
    ("d3 Triangle -0.9 0.25 1.7 1.0", "d3 Trapezoid -0.9 0.2 0.3 1.7", 6),
    ("d3 Triangle -0.9 0.25 1.7 1.0", "d3 Gaussian 0 1", 3),
    ("d3 Triangle", "d2 Triangle", 6),
    ("  term: d3 Triangle -0.9 0.25 1.7 1.0\n", "", 3),
    ("d3 Triangle -0.9 0.25 1.7", "d3 Triangle 0.24 0.25 0.26", 3),
    ("if error is e1 and", "if error is very e1 and", 85),
    ("if error is e1 and", "if error is e1 or", 85),
    ("change is d1 and error is e0", "error is e1 and error is e0", 79),
    ("change is d1 and error is e0", "chnge is d1 and error is e0", 79),
    ("Engine: mine", "Engine", 2),
    ("Engine: mine", "Motor: mine", 2),
    ("  range: -40 40", "  accumulate: 3", 24),
    ("OutputVariable: u\n", f"{SECOND}OutputVariable: u\n", 25),
]
FIS = [
    ("'sugeno'", "'tsukamoto'", 4),
    ("'sugeno'", "'mamdani'", 13),
    ("AndMethod='prod'", "AndMethod='min'", 9),
    ("AggMethod='sum'", "AggMethod='min'", 12),
    ("AggMethod='sum'\n", "", 2),
    ("NumRules=49", "NumRules=48", 8),
    ("NumInputs=2", "NumInputs=3", 6),
    ("MF2='t0'", "MF9='t0'", 20),
    ("'linzmf'", "'sigmf'", 20),
    ("[Output1]", "[Input1]", 38),
    ("'constant',[", "'linear',[0 0 ", 42),
    ("1 1, 25 (1) : 1", "1 1, 25 (0.5) : 1", 116),
    ("1 1, 25 (1) : 1", "0 1, 25 (1) : 1", 116),
    ("1 1, 25 (1) : 1", "1 1 1, 25 (1) : 1", 116),
    ("1 1, 25 (1) : 1", "1 1, 25 2 (1) : 1", 116),
    ("1 1, 25 (1) : 1", "1 2, 25 (1) : 1", 116),
    ("Range=[-9.5 12]", "Range=[-9.5 Inf]", 17),
]
OF_FLL = [
    ("Centroid 200", "Centroid 1e9", 22),
    ("aggregation: Maximum", "aggregation: none", 22),
    ("-1.000 1.500", "-inf 1.5", 4),
    ("-1.000 1.500", "-1e308 1e308", 2),
    ("is not rising", "is never rising", 34),
    ("then valve is close", "then valve is very close", 37),
    ("if level is high or", "if level is high) or", 37),
    ("if level is high or", "if (level is high) rate is rising or", 37),
    ("disjunction: AlgebraicSum", "disjunction: none", 37),
]
OF_FIS = [
    ("'centroid'", "'bisector'", 12),
    ("NumOutputs=1", "NumOutputs=2", 6),
    ("'gaussmf',[3 0]", "'sinmf',[3 0]", 27),
    ("'gaussmf',[3 0]", "'gaussmf',[0 0]", 27),
    ("Range=[-8 8]", "Range=[8 -8]", 22),
    ("3 3, 5 (1) : 1", "0 0, 5 (1) : 1", 49),
    ("3 3, 5 (1) : 1", "3 3, 5 (2) : 1", 49),
]
FAULTS = {
    "fll": (TEXTS["fll"], CHANGE, FLL),
    "fis": (TEXTS["fis"], CHANGE, FIS),
    "mamdani.fll": (MAMDANI_FLL.read_text(), MAMDANI_SIGNALS[".fll"], OF_FLL),
    "mamdani.fis": (MAMDANI_FIS.read_text(), MAMDANI_SIGNALS[".fis"], OF_FIS),
}


@pytest.mark.parametrize("of", FAULTS)
def test_what_a_design_cannot_hold_is_refused_with_its_line(of, tmp_path):
    text, signals, faults = FAULTS[of]
    file = tmp_path / f"mine.{of[-3:]}"
    for old, new, line in faults:
        assert old in text
        file.write_text(text.replace(old, new, 1))
        with refused() as found:
            imported(file, Wish(signals=signals))
        assert found.where == f"{file}: line {line}", (old, new)


#: (what stands in the file of Gaussians, what instead, line or None, of how many from the top)
OF_GAUSSIANS = [
    ("range: -1 1", "range: -2 1", 2),
    ("0.35355339059327379 -0.9", "0.3 -0.9", 6),
    ("-1.10000000000000009", "-0.1", 6),
    ("0.125", "0.0000000001", 8),
    ("f4 GaussianProduct 0 0", "f4 GaussianProduct 0 0.1 0", 9),
    ("f4 GaussianProduct 0 0.125", "f4 Gaussian 0.01 0.125 #", None),
]


def test_gaussians_that_are_not_those_of_a_hierarchy(tmp_path):
    text, file = GAUSSIAN.read_text(), tmp_path / "mine.fll"
    for old, new, line in OF_GAUSSIANS:
        assert old in text
        file.write_text(text.replace(old, new, -1 if line == 8 else 1))
        with refused() as found:
            imported(file, Wish())
        assert found.where == (f"{file}: line {line}" if line else str(file)), (old, new)


def test_an_unknown_signal_is_asked_for(tmp_path):
    file = tmp_path / "mine.fll"
    file.write_text(TEXTS["fll"])
    for signals, line in (
        ({}, 3),  # the other one is taken
        ({"change": "error_change", "error": "torque"}, 13),
        ({"error": "torque"}, 3),
        ({"speed": "error"}, None),
        ({"change": "error"}, None),
    ):
        with refused() as found:
            imported(file, Wish(signals=signals))
        assert line is None or found.where == f"{file}: line {line}"
    other = tmp_path / "other.fll"
    text = GAUSSIAN.read_text().replace("error", "torque").replace("deflection", "error")
    other.write_text(text)
    # The line is cut in its middle, where that is hangs on the folder.
    with pytest.raises(UserError, match=r"line 2: input 'torque': needs its signal"):
        imported(other, Wish())


def test_files_that_are_none(tmp_path):
    (tmp_path / "latin.fis").write_bytes(b"[System]\nName='\xe9'\n")
    (tmp_path / "x y.fll").write_text(TEXTS["fll"])
    (tmp_path / "terms.csv").write_text("")
    for name in ("no.fll", "latin.fis", "mine.fcl", "terms.csv", "", "x y.fll"):
        with refused():
            imported(tmp_path / name, Wish(signals=CHANGE))


LESSON = (ROOT / "docs" / "lesson.fll").read_text()
FORGOTTEN = "  rule: if error is N and error_change is P then command is none\n"


def test_what_can_be_sampled_is_told(tmp_path):
    path = tmp_path / "mine.fll"
    for old, new in (
        ("AlgebraicProduct", "Minimum"),
        ("Triangle -20.000 0.000 20.000", "Trapezoid -20 -5 5 20"),
        ("is N then command is back", "is N then command is back with 0.5"),
    ):
        path.write_text(LESSON.replace(old, new))
        with refused() as found:
            imported(path, Wish())
        assert "terms=7" in found.refusal
        assert imported(path, Wish(terms=(7, 7))).provenance["sampled"]["terms"] == "7 x 7"


def test_a_mistake_is_not_to_be_sampled(tmp_path):
    fis = MAMDANI_FIS.read_text()
    for name, text in (
        ("mine.fll", LESSON.replace(FORGOTTEN, "")),
        ("mine.fll", LESSON + FORGOTTEN.replace("none", "more")),
        ("mine.fll", LESSON.replace("command is back", "command is bakc")),
        ("mine.fll", LESSON.replace("WeightedAverage TakagiSugeno", "Nothing")),
        ("mine.fis", fis.replace("'", "")),  # without apostrophes
        ("mine.fis", fis.replace("'", '"')),
    ):
        (tmp_path / name).write_text(text)
        with refused() as found:
            imported(tmp_path / name, Wish())
        assert "terms=7" not in found.refusal
