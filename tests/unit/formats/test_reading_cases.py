"""What real files say that the usual ones do not: a file each, and what its program computes.

Numbers are those of pyfuzzylite 8.0.6 and, of .fis, of Octave's fuzzy-logic-toolkit 0.4.6.
"""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from imported_files import CHANGE, GAUSSIAN, TABLE, TEXTS, output, triangles
from wording import refused, refused_command

from hfc_design.cli import main
from hfc_design.files.loop_setup import load_design
from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish, assumptions_text, imported
from hfc_design.formats.reading import fis as any_fis
from hfc_design.formats.reading import fll as any_fll
from hfc_design.runtime import Controller

NAMES = {"e": "error", "de": "error_change"}
SIDE = """InputVariable: {}
  range: -1.000 1.000
  term: neg Triangle -2.000 -1.000 1.000
  term: pos Triangle -1.000 1.000 2.000
"""
PAIRS = [f"e is {a} and de is {b}" for a in ("neg", "pos") for b in ("neg", "pos")]
RULES = [
    f"  rule: if {pair} then u is {u}\n"
    for pair, u in zip(PAIRS, ("down", "zero", "zero", "up"), strict=True)
]
FLL = f"""Engine: probe
{SIDE.format("e")}{SIDE.format("de")}OutputVariable: u
  range: -1.000 1.000
  lock-range: false
  aggregation: none
  defuzzifier: WeightedAverage TakagiSugeno
  term: down Constant -1.000
  term: zero Constant 0.000
  term: up Constant 1.000
RuleBlock:
  conjunction: AlgebraicProduct
  disjunction: Maximum
  activation: General
{"".join(RULES)}"""
MF = "MF1='neg':'trimf',[-2 -1 1]\nMF2='pos':'trimf',[-1 1 2]\n"
FIS = f"""[System]
Name='probe'
Type='sugeno'
Version=2.0
NumInputs=2
NumOutputs=1
NumRules=4
AndMethod='prod'
OrMethod='max'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'
[Input1]
Name='e'
Range=[-1 1]
NumMFs=2
{MF}[Input2]
Name='de'
Range=[-1 1]
NumMFs=2
{MF}[Output1]
Name='u'
Range=[-1 1]
NumMFs=3
MF1='down':'constant',[-1]
MF2='zero':'constant',[0]
MF3='up':'constant',[1]
[Rules]
1 1, 1 (1) : 1
1 2, 2 (1) : 1
2 1, 2 (1) : 1
2 2, 3 (1) : 1
"""
MAMDANI = {"'sugeno'": "'mamdani'", "'wtaver'": "'centroid'", "'prod'": "'min'", "'sum'": "'max'"}
MAMDANI |= {f"'constant',[{k}]": f"'trimf',[{k - 1} {k} {k + 1}]" for k in (-1, 0, 1)}
MAX = {"aggregation: none": "aggregation: Maximum"}
MIN = {"AlgebraicProduct": "Minimum"}
ALIKE = {RULES[1]: "", RULES[2]: ""}
RAMPS = {"TakagiSugeno": "Tsukamoto", "Constant -1.000": "Ramp 0 -1"}
RAMPS |= {"Constant 0.000": "Ramp -1 1", "Constant 1.000": "Ramp 0 1"}
#: what -> (text, what stands in it -> what instead, point, output)
SAMPLED = {
    "lock-range": (
        FLL,
        {"Constant -1": "Constant -3", "lock-range: false": "lock-range: true"},
        (-1, -1),
        -1,
    ),
    "average": (FLL, MAX, (0.3, -0.2), 0.05813953488372095),
    "sum": (FLL, MAX | {"Average": "Sum", "is zero": "is up"}, (-0.5, 0.5), 0.375),
    "range 0 0": (FLL, MIN | {"u\n  range: -1.000 1": "u\n  range: 0 0#"}, (0.3, -0.2), 1 / 34),
    "any": (FLL, MIN | ALIKE | {PAIRS[0]: "e is any and de is neg"}, (0.3, -0.2), -0.2),
    "brackets": (
        FLL,
        MIN | ALIKE | {PAIRS[0]: f"({PAIRS[0]}) or ({PAIRS[1]})", PAIRS[3]: "e is pos"},
        (0.3, -0.2),
        0.3,
    ),
    "and before or": (
        FLL,
        {PAIRS[0]: "e is pos or e is neg and de is pos"},
        (0.3, -0.2),
        -0.65 / 2.4,
    ),
    "seldom": (FLL, {PAIRS[0]: "e is seldom neg"}, (0.3, -0.2), -0.1310320951467149),
    "Linear without a constant": (FLL, {"Constant 1.000": "Linear 1 1"}, (0.3, -0.2), -0.184),
    "Tsukamoto": (FLL, MIN | RAMPS, (0.3, -0.2), 0.525),
    "Mamdani": (FIS, MAMDANI | {"'sugeno'": "'Mamdani'"}, (0.3, -0.2), 0.015489656578008824),
    "dsigmf": (
        FIS,
        MAMDANI | {"'trimf',[-2 -1 1]": "'dsigmf',[9 -2 9 0]"},
        (0.3, -0.2),
        0.07024226577994365,
    ),
    "psigmf": (
        FIS,
        MAMDANI | {"'trimf',[-2 -1 1]": "'psigmf',[9 -2 -9 0]"},
        (0.3, -0.2),
        0.07024226570745128,
    ),
}
#: The same of what is taken as it is.
EXACT = {
    "lock-range": (FLL, {"lock-range: false": "lock-range: true"}, (0.3, -0.2), 0.05),
    "aggregation": (
        FLL.replace(RULES[2], RULES[2].replace("zero", "none")),
        MAX | {"zero Constant 0.000": "zero Constant 0.000\n  term: none Constant 0"},
        (0.3, -0.2),
        0.05,
    ),
    "range 0 0": (FLL, {"u\n  range: -1.000 1": "u\n  range: 0 0#"}, (0.3, -0.2), 0.05),
    "decimals": (FIS, {"1 2, 2 (1)": "1.000 2.000 , 2.000 (1.000)"}, (0.3, -0.2), 0.05),
    "-Inf": (FIS, {"'trimf',[-2 -1 1]": "'trapmf',[-Inf -Inf -1 1]"}, (0.3, -0.2), 0.05),
}


def changed(text, changes):
    for old, new in changes.items():
        assert old in text, old
        text = text.replace(old, new)
    return text


def written(folder, text, encoding="utf-8"):
    file = folder / f"mine.{'fis' if text.startswith('[') else 'fll'}"
    file.write_bytes(text.encode(encoding))
    return file


def taken(file, **wish):
    return imported(file, Wish(signals=NAMES, **wish))


@pytest.mark.parametrize("case", SAMPLED)
def test_what_is_sampled_is_what_its_program_computes(case):
    text, changes, point, wanted = SAMPLED[case]
    text = changed(text, changes)
    base = (any_fis if text.startswith("[") else any_fll).rule_base(text)
    found = base.outputs(*np.array([point], dtype=float).T)
    assert found[0] == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("case", EXACT)
def test_what_is_taken_as_it_is_computes_the_same(case, tmp_path):
    text, changes, point, wanted = EXACT[case]
    design = taken(written(tmp_path, changed(text, changes)))
    assert "sampled" not in design.provenance
    assert output(design, *point) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_files_of_windows_are_read(encoding, tmp_path):
    for text in (FLL, FIS):
        assert taken(written(tmp_path, text, encoding)).controller.names.output == "u"
    design = taken(written(tmp_path, FIS))
    FORMATS["csv"].write(design, tmp_path / "t")
    for file in (tmp_path / "t").iterdir():
        file.write_bytes(file.read_bytes().decode().encode(encoding))
    again = imported(tmp_path / "t", Wish())
    assert again.controller.rules.centroids == design.controller.rules.centroids


def test_last_bits_do_not_break_a_plateau():
    """Two rules scale one term and are added, to 0.1 + 0.2, a third one the term opposite."""
    text = changed(
        FIS, MAMDANI | {"'max'": "'sum'", "'centroid'": "'mom'", "OrMethod='sum'": "OrMethod='max'"}
    )
    rules = "0 1, 1 (0.1) : 1\n0 1, 1 (0.2) : 1\n1 0, 2 (0.3) : 1\n"
    text = text[: text.index("1 1, 1 (1)")].replace("NumRules=4", "NumRules=3") + rules
    text = text.replace("'trimf',[-2 -1 0]", "'trapmf',[-2 -1 -0.5 0]")
    text = text.replace("'trimf',[-1 0 1]", "'trapmf',[0 0.5 1 2]")
    base = any_fis.rule_base(text.replace("ImpMethod='min'", "ImpMethod='prod'"))
    assert 0.1 + 0.2 > 0.3
    assert base.outputs(np.array([-1.0]), np.array([-1.0]))[0] == pytest.approx(0.0, abs=1e-12)


def test_rules_that_share_a_number_are_added_as_in_matlab(tmp_path):
    for method in ("max", "probor"):
        text = FIS.replace("AggMethod='sum'", f"AggMethod='{method}'")
        design = taken(written(tmp_path, text))
        assert output(design, 0.3, -0.2) == pytest.approx(0.05, abs=1e-12)
        assert f"AggMethod {method}: " in assumptions_text(design.provenance)[0]
        design = taken(
            written(
                tmp_path,
                text.replace("2 1, 2 (1)", "2 1, 4 (1)")
                .replace("NumMFs=3", "NumMFs=4")
                .replace("[Rules]", "MF4='more':'constant',[0.5]\n[Rules]"),
            )
        )
        assert not assumptions_text(design.provenance)
    sampled = taken(written(tmp_path, changed(FLL, MAX)), terms=(3, 3))
    assert "fuzzylite 8" in assumptions_text(sampled.provenance)[0]


FOREIGN = {"InputVariable: e": "InputVariable: 误差", "de\n": "Δe\n", " de is": " Δe is"}
FOREIGN |= {"u\n": "Stellgröße\n", " u is": " Stellgröße is", " e is": " 误差 is"}
FOREIGN |= {"neg": "负", "zero": "nullgroß", "Engine: probe": "Engine: Größe"}


def test_names_in_any_alphabet_are_kept_beside_their_identifiers(tmp_path):
    file = written(tmp_path, changed(FLL, FOREIGN))
    design = imported(file, Wish(signals={"误差": "error", "Δe": "error_change"}))
    names = design.controller.names
    found = names.error, names.error_change, names.output, names.engine
    assert found == ("input_1", "Deltae", "Stellgroesse", "Groesse")
    assert [term.label for term in design.controller.error_terms] == ["term_1", "pos"]
    kept = design.provenance["names"]
    assert kept["input_1"] == "误差"
    assert kept["Stellgroesse"] == "Stellgröße"
    assert kept["Deltae.term_1"] == "负"
    assert assumptions_text(design.provenance)[0].endswith("more, see provenance.names")
    other = imported(file, Wish(signals={"误差": "error_change", "Δe": "error"}))
    assert other.controller.names.error_change == "input_1"


def test_one_output_of_several_is_taken(tmp_path):
    """What the other one is changes nothing, nor do rules that are about it alone."""
    more = "OutputVariable: w\n  defuzzifier: Centroid\n  term: a Triangle 0 1 2\nRuleBlock:"
    fll = FLL.replace("RuleBlock:", more).replace("then u is zero", "then w is a and u is zero")
    fll += "  rule: if e is neg then w is a with 0.5\n"
    fis = FIS.replace("NumOutputs=1", "NumOutputs=2").replace("NumRules=4", "NumRules=5")
    for k in (1, 2, 3):
        fis = fis.replace(f", {k} (1)", f", {k} 1 (1)")
    second = FIS[FIS.index("[Output1]") :].partition("[Rules]")[0].replace("Output1", "Output2")
    fis = fis.replace("[Rules]", second.replace("'u'", "'w'") + "[Rules]") + "1 0, 0 2 (0.5) : 1\n"
    for text, line in ((fll, 18), (fis, 33)):
        file = written(tmp_path, text)
        assert output(taken(file, output="u"), 0.3, -0.2) == pytest.approx(0.05, abs=1e-12)
        with refused() as found:
            taken(file)
        assert found.where == f"{file}: line {line}"
        out = tmp_path / file.suffix[1:]
        named = ["--signal", "e=error,de=error_change", "--out", out]
        assert refused_command("import", file, *named, "--output", "v").where == "--output v"
        words = ["import", str(file), *map(str, named), "--output", "u", "--name", "mine"]
        assert CliRunner().invoke(main, words).exit_code == 0
        design = json.loads(out.read_text())
        assert design["controller"]["names"]["output"] == "u"
        assert design["name"] == "mine"
    odd = fll.replace("then w is a and", "then w is very a and")
    with refused():
        taken(written(tmp_path, odd), output="u")


def controller_of(path, **wish):
    return imported(path, Wish(**wish)).controller


def test_flat_gaussians_are_a_hierarchy_of_one_unit_alone():
    """The pyfuzzylite file's own output at some points is the weighted average by hand."""
    design = imported(GAUSSIAN, Wish())
    unit = design.controller.units[0]
    assert design.controller.pd.kp == design.controller.pd.kd == 0.0
    assert (unit.row_input, unit.column_input) == ("deflection", "error")[::-1]
    terms = load_design("lin-lee-1999-table-1").controller.terms
    numbers = [(t.label, t.centre, t.half_width, t.rate) for t in design.controller.terms]
    for found, term in zip(numbers, terms, strict=True):
        assert found == (term.label, term.centre, term.half_width, pytest.approx(term.rate, 1e-15))
    rows = {"error": [], "deflection": []}
    for name, u in (("error", 0.3), ("deflection", -0.7)):
        distances = [max(abs(u - t.centre) - t.half_width, 0.0) for t in terms]
        rows[name] = [np.exp(-t.rate * d * d) for t, d in zip(terms, distances, strict=True)]
    column = sum(j * d for j, d in enumerate(rows["error"])) / sum(rows["error"])
    row = sum(i * d for i, d in enumerate(rows["deflection"])) / sum(rows["deflection"])
    signals = {"error": 0.3, "error_rate": 9.0, "deflection": -0.7}
    assert Controller(design).step(signals) == pytest.approx(row - column / 2, abs=1e-12)


@pytest.mark.parametrize("suffix", TEXTS)
def test_terms_in_any_order_are_sorted_and_the_table_with_them(tmp_path, suffix):
    file = tmp_path / f"mine.{suffix}"
    file.write_text(TEXTS[suffix])
    found = controller_of(file, signals=CHANGE)
    for terms in (found.error_terms, found.error_change_terms):
        edges = [(t.left, t.centre, t.right) for t in terms]
        assert edges == [row[1:] for row in triangles(range(7))]
    assert [list(row) for row in found.rules.centroids] == TABLE
    # With the signals named the other way round the table is the transposed one.
    other = controller_of(file, signals={"change": "error", "error": "error_change"})
    assert [list(row) for row in zip(*other.rules.centroids, strict=True)] == TABLE


#: (error, change, output) of the texts above in pyfuzzylite 8.0.6; Octave's fuzzy-logic-toolkit
#: 0.4.6 gives the same but for 1e-14, with linzmf and linsmf, which only MATLAB has, as trapmf.
THE_PROGRAMS_SAY = [
    (-4.425, -7.282, -2.7178249257424683),
    (-0.985, -6.168, -26.804041613344157),
    (-8.07, -0.866, 19.169686756311147),
    (10.236, 7.71, -14.39653818159953),
    (6.951, -4.729, -2.9608886974273987),
    (2.039, -3.551, 0.8227702208369054),
    (-5.788, -7.217, -1.05006906668974),
    (-4.89, 10.441, 2.197253485598709),
    (-9.5, 12.0, 23.46720670093304),
    (-6.0, 0.25, -19.279320662762114),
    (1.7, -0.9, 11.154143876630698),
]


@pytest.mark.parametrize("suffix", TEXTS)
def test_the_design_computes_what_the_real_programs_do(tmp_path, suffix):
    file = tmp_path / f"mine.{suffix}"
    file.write_text(TEXTS[suffix])
    runtime = Controller(imported(file, Wish(signals=CHANGE)))
    for error, change, wanted in THE_PROGRAMS_SAY:
        assert output(runtime, error, change) == pytest.approx(wanted, abs=1e-12)


def test_an_output_ends_where_its_range_does(tmp_path):
    text, changes, *_ = SAMPLED["lock-range"]
    file = written(tmp_path, changed(text, changes))
    with refused() as found:
        taken(file)
    assert found.where == f"{file}: line 12"
    assert output(taken(file, terms=(7, 7)), -1.0, -1.0) == pytest.approx(-1.0, abs=1e-12)
