"""What the readers say that a Mamdani system computes, against the programs that its file is for.

Measured: pyfuzzylite 4e-16, fuzzylite's C++ tool 3e-15 (2e-6 where sums are taken), Octave's
evalfis 1e-14. And the deviation
that an import prints is that of the design from the program itself.
"""

import numpy as np
import pytest
from fuzzylite_tool import in_python, in_tool
from imported_files import MAMDANI_FIS, MAMDANI_FLL, MAMDANI_SUM, SHARED, SHARED_SIGNALS, output

from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish, imported
from hfc_design.formats.reading import fis as any_fis
from hfc_design.formats.reading import fll as any_fll

FLL_SIGNALS = {"level": "error", "rate": "error_change"}
DEFUZZIFIERS = ["Centroid 200", "Centroid", "Bisector 150"]
DEFUZZIFIERS += [f"{name} 100" for name in ("MeanOfMaximum", "SmallestOfMaximum")]
DEFUZZIFIERS += ["LargestOfMaximum 100"]


def random_points(base, count):
    random = np.random.default_rng(5)
    return np.stack([random.uniform(v.low, v.high, count) for v in base.inputs], axis=1)


def evaluated(file, points, names=FLL_SIGNALS):
    inputs = dict(zip(names, points.T.tolist(), strict=True))
    return np.array(in_python("evaluate_fll.py", file=str(file), inputs=inputs))


@pytest.mark.parametrize("name", ["fll", "fis"])
def test_pyfuzzylite_reads_the_names_and_ranges_that_were_imported(name, tmp_path):
    design = imported(SHARED[name], Wish(signals=SHARED_SIGNALS))
    FORMATS["fll"].write(design, tmp_path / "out")
    (again,) = (tmp_path / "out").glob("*.fll")
    found, wanted = (in_python("describe_fll.py", file) for file in (again, SHARED["fll"]))
    if name == "fis":  # which has another one
        assert found["variables"]["drift"]["range"] == [-4.0, 4.0]
        wanted["variables"]["drift"]["range"] = [-4.0, 4.0]
    assert found == wanted
    points = np.random.default_rng(6).uniform(-6.0, 6.0, (300, 2)) * [4.0, 1.0]
    read = [evaluated(file, points, SHARED_SIGNALS) for file in (again, SHARED["fll"])]
    assert np.abs(read[0] - read[1]).max() <= 1e-14
    assert np.abs(outputs(design, points) - read[1]).max() <= 1e-13


def outputs(design, points):
    return np.array([output(design, *point) for point in points.tolist()])


@pytest.mark.parametrize("defuzzifier", DEFUZZIFIERS)
@pytest.mark.parametrize("aggregation", ["Maximum", "UnboundedSum", "AlgebraicSum"])
def test_fll_as_pyfuzzylite_and_its_tool_have_it(defuzzifier, aggregation, program, tmp_path):
    file = tmp_path / "mamdani.fll"
    text = MAMDANI_FLL.read_text().replace("Centroid 200", defuzzifier)
    file.write_text(text.replace("aggregation: Maximum", f"aggregation: {aggregation}"))
    base = any_fll.rule_base(file.read_text())
    points = random_points(base, 300)
    found = base.outputs(*points.T)
    # With degrees that differ by rounding only made equal there, see evaluate_engines.py.
    job = {"texts": [file.read_text()], "points": [points.T.tolist()]}
    assert np.abs(found - in_python("evaluate_engines.py", **job)[0]).max() <= 1e-12
    if defuzzifier.startswith("Centroid "):
        tool = program("fuzzylite")
        read = in_tool(tool, tmp_path / "points.fld", "fll", file, *FLL_SIGNALS, points)
        # It drops rules that fire at less than 1e-6, which a sum sees.
        assert np.abs(found - read).max() <= (1e-12 if aggregation == "Maximum" else 5e-6)


@pytest.mark.parametrize("file", [MAMDANI_FIS, MAMDANI_SUM], ids=lambda file: file.name)
@pytest.mark.parametrize("method", ["centroid", "mom"])
def test_fis_as_octave_has_it(file, method, octave, tmp_path):
    copy = tmp_path / "mamdani.fis"
    copy.write_text(file.read_text().replace("'centroid'", f"'{method}'"))
    base = any_fis.rule_base(copy.read_text())
    points = random_points(base, 60)
    np.savetxt(tmp_path / "points", points, fmt="%.17g")
    read = octave("evaluate_fis.m", copy, tmp_path / "points", tmp_path / "out")
    assert np.abs(base.outputs(*points.T) - read).max() <= 1e-12
