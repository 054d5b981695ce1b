"""Rule bases of every kind, Mamdani's too, sampled to a table; see tests/interop/test_import.py.

The oracle of a single output is SciPy's quadrature of the aggregated set, written out here.
"""

import json
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner
from imported_files import (
    MAMDANI_FIS,
    MAMDANI_FLL,
    MAMDANI_SIGNALS,
    output,
)
from places import ROOT
from scipy.integrate import quad
from wording import refused, refused_command

from hfc_design.cli import main
from hfc_design.formats.reading import Wish, imported, sampling
from hfc_design.formats.reading import fis as any_fis
from hfc_design.formats.reading import fll as any_fll
from hfc_design.runtime import Controller


def taken(file, **wish):
    return imported(file, Wish(signals=MAMDANI_SIGNALS[file.suffix], **wish))


def test_a_centroid_is_that_of_quadrature():
    """Minimum, maximum: two cut triangles of the file, at an input that fires both."""
    base = any_fis.rule_base(MAMDANI_FIS.read_text())
    error, change = 8.0, 0.0
    zero, pos = 1.0 - error / 40.0, error / 40.0
    near = np.exp(-0.5 * (8.0 / 3.0) ** 2)  # neg and pos of the change, zero is 1
    heights = {5.0: pos, 0.0: max(zero, min(pos, near)), -5.0: min(zero, near)}
    heights |= {10.0: min(pos, near)}
    heights[5.0] = max(pos, min(zero, near))

    def whole(y):
        return max(min(h, max(1.0 - abs(y - c) / 5.0, 0.0)) for c, h in heights.items())

    corners = np.linspace(-10.0, 10.0, 81)
    area = sum(quad(whole, a, b)[0] for a, b in pairwise(corners))
    moment = sum(quad(lambda y: y * whole(y), a, b)[0] for a, b in pairwise(corners))
    found = base.outputs(np.array([error]), np.array([change]))
    assert found[0] == pytest.approx(moment / area, rel=2e-3)  # evalfis has 101 places


@pytest.mark.parametrize("file", [MAMDANI_FLL, MAMDANI_FIS], ids=lambda file: file.name)
@pytest.mark.parametrize("terms", [None, (2, 2), (9, 7)])
def test_the_deviation_is_that_of_the_design_from_the_file(file, terms):
    reader = {".fll": any_fll, ".fis": any_fis}[file.suffix]
    base, design = reader.rule_base(file.read_text()), taken(file, terms=terms)
    controller, told = design.controller, design.provenance["sampled"]
    shape = terms or tuple(len(variable.terms) for variable in base.inputs)
    assert controller.rules.shape() == shape
    assert told["terms"] == f"{shape[0]} x {shape[1]}"
    runtime = Controller(design)
    centres = [
        [term.centre for term in terms]
        for terms in (controller.error_terms, controller.error_change_terms)
    ]
    for i, error in enumerate(centres[0]):
        for j, change in enumerate(centres[1]):
            (wanted,) = base.outputs(np.array([error]), np.array([change]))
            assert output(runtime, error, change) == pytest.approx(wanted, abs=1e-12)
            assert controller.rules.centroids[i][j] == pytest.approx(wanted, abs=1e-12)
    most = told["largest_deviation"]
    x, y = told["at"].values()
    off = output(runtime, x, y) - base.outputs(np.array([x]), np.array([y]))[0]
    assert abs(off) == pytest.approx(most, rel=1e-9)
    random = np.random.default_rng(4)
    points = [random.uniform(v.low, v.high, 500) for v in base.inputs]
    found = [output(runtime, *pair) for pair in zip(*map(np.ndarray.tolist, points), strict=True)]
    assert np.abs(found - base.outputs(*points)).max() <= 1.03 * most


def test_the_command_tells_the_deviation(tmp_path):
    out = tmp_path / "mine.json"
    named = [f"--signal={name}={signal}" for name, signal in MAMDANI_SIGNALS[".fis"].items()]
    arguments = ["import", str(MAMDANI_FIS), "--out", str(out), *named]
    done = CliRunner().invoke(main, [*arguments, "--terms", "5x3"])
    line, names, assumed, path = done.stdout.splitlines()
    assert names.startswith(
        "renamed, as names must be identifiers: Position error is Position_error, "
    )
    told = json.loads(out.read_text())["provenance"]["sampled"]
    assert line.startswith("sampled to 5 x 3 terms: output deviates by at most ")
    assert f"{told['largest_deviation']:.3g} (7.3 % of its range), at Position" in line
    assert "--terms" not in line  # which was given
    assert assumed.startswith("plant feed-drive, sample time 0.01 s assumed")
    assert path == str(out)
    line = CliRunner().invoke(main, [*arguments, "--force"]).stdout.splitlines()[0]
    assert line.startswith("sampled to 3 x 3 terms: output deviates by at most 1.42")
    assert line.endswith("points; more terms, --terms up to 11, usually reduce this")
    for wrong in ("1", "12", "5x", "3x12", "many"):
        assert refused_command(*arguments, "--force", "--terms", wrong).where == f"--terms {wrong}"


def test_where_no_rule_fires_is_named(tmp_path):
    copy = tmp_path / "mine.fll"
    text = MAMDANI_FLL.read_text().replace("Bell 0.100 0.300 2.500", "Triangle -0.2 0.1 0.4")
    copy.write_text(text.replace("if level is high or rate is very rising", "if level is high"))
    copy.write_text(copy.read_text().replace("high Sigmoid 0.700 12.000", "high Ramp 0.6 0.9"))
    with refused():
        taken(copy)
    copy.write_text(copy.read_text().replace("default: nan", "default: 0.25"))
    assert taken(copy).controller.rules.shape() == (3, 4)


@pytest.mark.parametrize("file", [MAMDANI_FLL, MAMDANI_FIS], ids=lambda file: file.name)
def test_no_last_bit_of_an_output_moves_a_term(file, monkeypatch):
    """Two places at which a term fits as well are told apart by their order."""
    base = {".fll": any_fll, ".fis": any_fis}[file.suffix].rule_base(file.read_text())
    exact, rng, found = sampling._on, np.random.default_rng(1), []
    for size in (0.0, 1e-15, 1e-13, 1e-13):

        def off(*given, size=size):
            outputs = exact(*given)
            return outputs * (1.0 + size * rng.uniform(-1.0, 1.0, outputs.shape))

        monkeypatch.setattr(sampling, "_on", off)
        system, told = sampling.sampled(base, (6, 5))
        terms = [[shape.low for shape in side.terms] for side in system.inputs]
        found.append((terms, told["at"]))
    assert all(one == found[0] for one in found)


LESSON = (ROOT / "docs" / "lesson.fll").read_text()
FORGOTTEN = "  rule: if error is N and error_change is P then command is none\n"


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
    out = tmp_path / "mine.json"
    done = CliRunner().invoke(main, ["import", str(path), "--terms", "3", "--out", str(out)])
    assert done.exit_code == 0
    sampled = json.loads(out.read_text())["provenance"]["sampled"]
    told = ["error is N and error_change is P"] if forgotten else []
    assert sampled.get("without_rule", []) == told
    assert all(f"no rule for {pair}" in done.stderr for pair in told)
    assert ("warning" in done.stderr) == forgotten


def test_what_says_the_opposite_on_the_other_side_still_does():
    """And a middle term stays on 0, as a search needs it."""
    for terms in ((3, 5), (4, 6), (9, 7), (11, 11)):
        controller = taken(MAMDANI_FIS, terms=terms).controller
        for side in (controller.error_terms, controller.error_change_terms):
            centres = [term.centre for term in side]
            assert centres == [-centre for centre in centres[::-1]]
        table = controller.rules.centroids
        for row, opposite in zip(table, table[::-1], strict=True):
            assert row == pytest.approx([-value for value in opposite[::-1]], abs=1e-12)
