"""The benchmarks still find what they time, and time what the evaluator computes."""

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
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


@pytest.mark.slow
@pytest.mark.parametrize("code", [EVALUATOR, CONTROLLERS, RUNTIME, DRIVES, POLISH])
def test_a_benchmark_runs(code):
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=BENCHMARKS, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
