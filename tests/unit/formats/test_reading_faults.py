"""Files that no design can hold are refused in one line with file and line."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from imported_files import CHANGE, GAUSSIAN, PYFUZZYLITE, TEXTS

from hfc_design.core.records import UserError
from hfc_design.formats.reading import Wish, imported
from hfc_design.runtime import Controller

FLL_FAULTS = [
    ("defuzzifier: WeightedAverage", "defuzzifier: Tsukamoto", 25, "only WeightedAverage"),
    ("defuzzifier: WeightedAverage", "defuzzifier: Centroid 100", 26, "shape of the term u00"),
    ("  defuzzifier: WeightedAverage\n", "", 23, "OutputVariable u has no defuzzifier"),
    ("conjunction: AlgebraicProduct", "conjunction: Minimum", 76, "only AlgebraicProduct"),
    ("d0 Ramp -6.3", "d0 Triangle -13 -9.5 -6.3 #", 7, "the lowest, has to be 1 from its centre"),
    ("range: -12.000 12.000", "range: twelve", 5, "'twelve' has to be a number"),
    ("Constant", "Linear", 26, "only NAME Constant NUMBER"),
    ("  range: -40 40", "  lock-previous: true", 24, "cannot be imported, only false"),
    ("d3 Triangle", "d3 Bell", 6, "only Triangle or Trapezoid or Ramp or Gaussian"),
    ("d3 Triangle -0.9", "d3 Triangle 0.25", 6, "vertical edge"),
    ("d3 Triangle -0.9", "d3 Triangle 1.9", 6, "corners have to rise"),
    ("d3 Triangle -0.9 0.25 1.7 1.0", "d3 Triangle -0.9 0.25 1.7 0.5", 6, "only the height 1"),
    ("d3 Triangle -0.9 0.25 1.7 1.0", "d3 Trapezoid -0.9 0.2 0.3 1.7", 6, "flat from 0.2 to 0.3"),
    ("d3 Triangle -0.9 0.25 1.7 1.0", "d3 Gaussian 0 1", 3, "mixes Gaussian and straight"),
    ("d3 Triangle -0.9 0.25 1.7 1.0", "d3 Triangle -0.9 0.25", 6, "has 3 numbers"),
    ("d3 Triangle", "d2 Triangle", 6, "term d2 stands twice"),
    ("  term: d3 Triangle -0.9 0.25 1.7 1.0\n", "", 3, "there is a gap between d2"),
    ("d3 Triangle -0.9 0.25 1.7", "d3 Triangle 0.24 0.25 0.26", 3, "there is a gap between"),
    ("then u is u00", "then u is u00 with 0.5", 78, "only of weight 1"),
    ("if error is e1 and", "if error is very e1 and", 85, "cannot be imported, only: if change"),
    ("if error is e1 and", "if error is e1 or", 85, "cannot be imported, only: if change"),
    ("change is d1 and error is e0", "change is d0 and error is e0", 79, "the first is in line 78"),
    ("change is d1 and error is e0", "error is e1 and error is e0", 79, "read both inputs"),
    (
        "change is d1 and error is e0",
        "chnge is d1 and error is e0",
        79,
        "'chnge' is no input; there is",
    ),
    ("u is u11", "u is u99", 86, "'u99' is no term of u"),
    ("Engine: mine", "Engine", 2, "no line of FLL"),
    ("Engine: mine", "Motor: mine", 2, "stands before any block"),
    ("  enabled: true", "  enabled: maybe", 4, "enabled = 'maybe' cannot be imported"),
    ("  range: -40 40", "  accumulate: 3", 24, "key 'accumulate' is not known"),
    (
        "OutputVariable: u\n",
        "OutputVariable: w\n  defuzzifier: WeightedAverage\nOutputVariable: u\n",
        25,
        "2 of OutputVariable",
    ),
]
FIS_FAULTS = [
    ("'sugeno'", "'tsukamoto'", 4, "Type = 'tsukamoto' cannot be imported, only sugeno"),
    ("'sugeno'", "'mamdani'", 13, "DefuzzMethod = 'wtaver' cannot be imported, only centroid"),
    ("AndMethod='prod'", "AndMethod='min'", 9, "only prod"),
    ("AggMethod='sum'", "AggMethod='max'", 12, "only sum"),
    ("AggMethod='sum'\n", "", 2, "[System] has no AggMethod"),
    ("NumRules=49", "NumRules=48", 8, "NumRules=48, but there are 49"),
    ("NumInputs=2", "NumInputs=3", 6, "only 2"),
    ("NumMFs=7", "NumMFs=5", 18, "NumMFs=5, but there are 7"),
    ("MF2='t0'", "MF9='t0'", 20, "here belongs MF2='NAME'"),
    ("'linzmf'", "'sigmf'", 20, "only trimf or trapmf or linzmf"),
    ("[Input2]", "[Input3]", 27, "section = 'Input3' cannot be imported"),
    ("[Output1]", "[Input1]", 38, "a second section [Input1]"),
    ("'constant',[", "'linear',[0 0 ", 42, "only constant"),
    ("1 1, 25 (1) : 1", "1 1, 25 (1) : 2", 116, "only 1"),
    ("1 1, 25 (1) : 1", "1 1, 25 (0.5) : 1", 116, "of weight 0.5"),
    ("1 1, 25 (1) : 1", "-1 1, 25 (1) : 1", 116, "allowed is 1 to 7"),
    ("1 1, 25 (1) : 1", "0 1, 25 (1) : 1", 116, "allowed is 1 to 7"),
    ("1 1, 25 (1) : 1", "1 1, 50 (1) : 1", 116, "allowed is 1 to 49"),
    ("1 1, 25 (1) : 1", "1 1 1, 25 (1) : 1", 116, "is no rule of two inputs"),
    ("1 1, 25 (1) : 1", "1 2, 25 (1) : 1", 116, "a second rule for the same two terms"),
    ("Range=[-9.5 12]", "Range=[-9.5 Inf]", 17, "has to be a finite number"),
    ("Range=[-9.5 12]", "Range=[12 -9.5]", 16, "its range has to rise"),
]


@pytest.mark.parametrize(
    ("suffix", "old", "new", "line", "message"),
    [("fll", *fault) for fault in FLL_FAULTS] + [("fis", *fault) for fault in FIS_FAULTS],
)
def test_what_a_design_cannot_hold_is_refused_with_its_line(
    tmp_path, suffix, old, new, line, message
):
    file = tmp_path / f"mine.{suffix}"
    assert old in TEXTS[suffix]
    file.write_text(TEXTS[suffix].replace(old, new, 1))
    with pytest.raises(UserError) as caught:
        imported(file, Wish(signals=CHANGE))
    assert str(caught.value).startswith(f"{file}: line {line}: ")
    assert message in str(caught.value)


def test_a_missing_rule_is_named(tmp_path):
    file = tmp_path / "mine.fll"
    file.write_text(re.sub(r".*then u is u23\n", "", TEXTS["fll"]))
    with pytest.raises(UserError, match=r"there is no rule for change is d3 and error is e2"):
        imported(file, Wish(signals=CHANGE))


def test_an_unknown_signal_is_asked_for(tmp_path):
    file = tmp_path / "mine.fll"
    file.write_text(TEXTS["fll"])
    free = r"line 3: input 'change': .* signals={'change': 'error_change'}; there is error_change$"
    with pytest.raises(UserError, match=free):  # the other one is taken
        imported(file, Wish())
    free = r"line 13: input 'error': .* signals={'error': 'error'}; there is error$"
    with pytest.raises(UserError, match=free):
        imported(file, Wish(signals={"change": "error_change", "error": "torque"}))
    free = r"line 3: input 'change': .* signals={'change': 'error'}; there is error, error_change$"
    with pytest.raises(UserError, match=free):
        imported(file, Wish(signals={"error": "torque"}))
    with pytest.raises(UserError, match=r"signals: speed: no such input"):
        imported(file, Wish(signals={"speed": "error"}))
    with pytest.raises(UserError, match=r"both inputs are the signal 'error'"):
        imported(file, Wish(signals={"change": "error"}))
    with pytest.raises(UserError, match=r"line 2: input 'torque': which signal"):
        imported(changed(tmp_path, GAUSSIAN, "error", "torque", "deflection", "error"), Wish())


SIGMA = "0.35355339059327379"
OF_GAUSSIANS = [
    ("range: -1 1", "range: -2 1", "line 2: input error: its range has to lie within -1 and 1"),
    (f"{SIGMA} -0.9", "0.3 -0.9", "line 6: term f1: both flanks have to be equally wide"),
    ("-1.10000000000000009", "-0.1", "line 6: term f1: its top may not fall"),
    ("0.125", "0.0000000001", "line 8: term f3: its top may not fall, its width has to be 1e-9"),
    ("f4 GaussianProduct 0 0", "f4 GaussianProduct 0 0.1 0", "line 9: term f4: only the height 1"),
    ("f4 GaussianProduct 0 0.125", "f4 Gaussian 0.01 0.125 #", "both inputs need the same terms"),
]


@pytest.mark.parametrize(("old", "new", "message"), OF_GAUSSIANS)
def test_gaussians_that_are_not_those_of_a_hierarchy(tmp_path, old, new, message):
    text = GAUSSIAN.read_text()
    assert old in text
    file = tmp_path / "mine.fll"
    count = -1 if "f3" in message else 1
    file.write_text(text.replace(old, new, count))
    with pytest.raises(UserError) as caught:
        imported(file, Wish())
    assert str(caught.value).startswith(f"{file}: {message}")


def test_one_input_of_gaussians_and_one_of_triangles(tmp_path):
    straight, flat = (file.read_text().split("InputVariable") for file in (PYFUZZYLITE, GAUSSIAN))
    file = tmp_path / "mine.fll"
    text = "InputVariable".join([*straight[:2], *flat[2:]])
    rules = [
        f"  rule: if error is {label} and deflection is f{k} then unit_0 is r00"
        for label in ("NL", "NM", "NS", "ZR", "PS", "PM", "PL")
        for k in range(1, 8)
    ]
    kept = [line for line in text.splitlines() if "rule: " not in line]
    file.write_text("\n".join(kept + rules))
    with pytest.raises(UserError, match=r"one input has Gaussian terms and the other straight"):
        imported(file, Wish())


def changed(folder, file, *pairs):
    text = file.read_text()
    for old, new in zip(pairs[::2], pairs[1::2], strict=True):
        text = text.replace(old, new)
    copy = folder / file.name
    copy.write_text(text)
    return copy


def test_files_that_are_none(tmp_path):
    (tmp_path / "latin.fis").write_bytes(b"[System]\nName='\xe9'\n")
    (tmp_path / "x y.fll").write_text(TEXTS["fll"])
    (tmp_path / "terms.csv").write_text("")
    for path, message in (
        (tmp_path / "no.fll", "cannot be read: No such file"),
        (tmp_path / "latin.fis", "is not a text in UTF-8"),
        (tmp_path / "mine.fcl", "is neither .fll, .fis, .txt, .hal nor a folder of .csv tables"),
        (tmp_path / "terms.csv", "has to be named rules.csv"),
        (tmp_path, "has no rules.csv"),
        (tmp_path / "x y.fll", "name='x y'"),
    ):
        with pytest.raises(UserError) as caught:
            imported(path, Wish(signals=CHANGE))
        assert message in str(caught.value)


@given(st.data())
@settings(max_examples=150, deadline=None)
def test_any_damage_is_refused_or_gives_a_design(tmp_path_factory, data):
    suffix = data.draw(st.sampled_from(sorted(TEXTS)))
    lines = TEXTS[suffix].splitlines()
    for _ in range(data.draw(st.integers(1, 3))):
        k = data.draw(st.integers(0, len(lines) - 1))
        words = re.split(r"([\s,:=()\[\]]+)", lines[k])
        m = data.draw(st.integers(0, len(words) - 1))
        other = data.draw(
            st.sampled_from(
                ["", "1e999", "-inf", "0", "'", "[", "1_0", "nan", "%", "#", "é", "9" * 400]
            )
            | st.text(max_size=6)
            | st.floats().map(repr)
        )
        words[m] = other
        lines[k] = "".join(words)
    file = tmp_path_factory.mktemp("damaged") / f"mine.{suffix}"
    file.write_text("\n".join(lines), encoding="utf-8", errors="replace")
    try:
        found = imported(file, Wish(signals=CHANGE))
    except UserError as error:
        assert "\n" not in str(error)
        return
    assert np.isfinite(Controller(found).step({"error": 3.0}))
