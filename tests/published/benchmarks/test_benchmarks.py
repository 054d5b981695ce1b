"""The benchmarks still find what they time, and time what the evaluator computes."""

import json
import subprocess
import sys
from statistics import median

import pytest
from places import ROOT

BENCHMARKS = ROOT / "benchmarks"
EVALUATOR = """
import ensembles, evaluator, populations, numpy as np
from evaluator_peer import make, on_machines, prepare
work = make(3, 40)
several = on_machines(work, 2)().merit
assert several.shape == (3, 2, 1) and (several[:, 0, 0] == prepare(work)()).all()
assert (several[:, 1] != several[:, 0]).all()
np.testing.assert_allclose(prepare(work)(), prepare(work, np.float64)(), rtol=1e-4)
"""
CONTROLLERS = """
import controllers
work = controllers.prepared("jee-koren-2004-pid", "feed-drive-circle", 2)
assert work.operations > 50 and work.run().merit.shape == (2, 1, 1)
"""
RUNTIME = """
import runtime, numpy as np
design = runtime.design_of("jee-koren-2004-pid")
samples = np.linspace(-30.0, 30.0, 150)[:, None]
assert all(one.deviation < 1e-4 for one in runtime.of_axes(design, samples).values())
design = runtime.design_of("lin-gai-2009-fuzzy-sliding-compensated")
assert all(one.deviation < 1e-6 for one in runtime.contenders(design, "five-axis-program").values())
"""
DRIVES = """
import drives, numpy as np
axes = drives.axes_of("lin-gai-2009-pid", "five-axis-program", 3)
for flags, real, close in ((["-DDOUBLE"], np.float64, 1e-9), ([], np.float32, 1e-3)):
    found = drives.scored(drives.built(*flags), axes, real)
    np.testing.assert_allclose(found[:, 0], [axis.rms for axis in axes], rtol=close)
    assert (found[:, 1] != found[:, 0]).all()
"""
POLISH = """
import polish, numpy as np
from hfc_design.files.named_scenario import load_scenario
scenario = load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})
genome = polish.Problem(scenario).genome
own = polish.Residuals(scenario, genome.fresh(np.array([7]), np.random.default_rng(0)), 1e-2)
at = 0.01 * np.random.default_rng(1).standard_normal(own.own.size)
value, slope = own.linear(at)
np.testing.assert_allclose(value, own.values(at), rtol=1e-9)
for k in (0, 3, 60):
    step = 1e-5 * (np.arange(own.own.size) == k)
    change = (own.values(at + step) - own.values(at - step)) / 2e-5
    np.testing.assert_allclose(slope[:, k], change, atol=1e-5 * abs(change).max() + 1e-9)
"""
# The card's way, on the processor: what float64 would give are the sums of SciPy's Radau.
ACCELERATOR = """
import json, accelerator, accelerator_parts as parts, evaluator_peer, jax, numpy as np
import sys, tempfile, tomllib
from pathlib import Path
recorded = Path("../tests/data/c_axis_published_controllers.json").read_text()
sums = json.loads(recorded)["table-1-no-load"]
exact = 3e3 / sums["sum_abs_error"] + 1e2 / sums["sum_abs_error_rate"]
design, scenario = evaluator_peer.load_design("lin-lee-1999-table-1"), "c-axis-ramp"
gains = evaluator_peer.controller_of(design, parts.load_scenario(scenario))[1]
file = Path(tempfile.mkdtemp(), "check.npz")
work = evaluator_peer.make(1, 1000)
own = {name: leaf for name, leaf in gains._asdict().items() if name in work._fields}
parts.save(work._replace(**own), file)
jax.default_backend = lambda: "cuda"
def told(value):
    np.save(file.with_suffix(".npy"), [value])
    return parts.main("check", json.dumps([str(file)]))
assert told(exact)["deviation"] < 2e-5
for wrong in (exact * (1 + 4e-5), exact * (1 - 4e-5), np.nan):
    assert told(wrong)["told"].startswith("ArithmeticError: a score deviates by")

parts.load_scenario("c-axis-practical")  # has units
asked = tomllib.loads(Path("../pyproject.toml").read_text())["project"]["dependencies"]
names = {one.partition(">")[0].replace("-", "_") for one in asked}
assert names & set(sys.modules) <= set(accelerator.NEEDED)
"""


@pytest.mark.parametrize(
    "code",
    [EVALUATOR + CONTROLLERS + RUNTIME + DRIVES + POLISH, ACCELERATOR],  # which counts its imports
    ids=["processor", "card"],
)
def test_the_benchmarks_run(code):
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=BENCHMARKS, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()


def test_a_table_of_a_card_says_what_its_file_says(tmp_path):
    out = tmp_path / "out.json"
    command = [sys.executable, "accelerator.py", "--quick", "--out", out]
    command += ["--parts", "check", "evaluator"]
    done = subprocess.run(command, cwd=BENCHMARKS, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    head, _, *lines = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in done.stdout.splitlines()
        if line.startswith("|")
    ]
    rows = json.loads(out.read_text())["rows"]
    assert [row["on"] for row in rows] == ["cpu", "cpu", "cuda", "cuda"]
    for line, row in zip(lines, sorted(rows, key=lambda row: row["part"]), strict=True):
        told = dict(zip(head, line, strict=True))
        assert told["part"] == row["part"]
        if row["state"] != "measured":
            assert row["told"] in told["remark"]
            continue
        assert float(told["compile [s]"]) == pytest.approx(row["compile_s"], abs=0.06)
        if row["part"] == "evaluator, 1,000":
            turn = float(told["turn, median (min to max) [s]"].partition(" ")[0])
            assert turn == pytest.approx(median(row["turns_s"]), rel=0.01)
            assert float(told["individual-steps/s"]) == pytest.approx(1e6 / turn, rel=0.02)


def test_what_a_bare_machine_lacks_is_one_line():
    command = [sys.executable, "-S", BENCHMARKS / "accelerator.py"]  # no packages
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("missing: jax jaxtyping ")
