"""What several files about batches share."""

import itertools
import subprocess
import sys

import numpy as np
import pytest
from batches import batch, written
from run_folders import batch_folder, hfc


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    from dask_cluster import Cluster  # which skips where the package distributed is missing

    with Cluster(tmp_path_factory.mktemp("dask")) as found:
        yield found


@pytest.fixture
def started(tmp_path):
    """Start ``hfc batch`` on the grid, beside it, in a process group of its own."""
    from dask_cluster import ENVIRONMENT, GRID, killed

    path, processes = written(tmp_path, GRID), []

    def start(*arguments):
        command = [sys.executable, "-m", "hfc_design", "batch", path, "--out", tmp_path / "out"]
        processes.append(
            subprocess.Popen(
                [*command, *arguments],
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
                cwd=tmp_path,
                env=ENVIRONMENT,
            )
        )
        return processes[-1]

    yield start
    for process in processes:
        killed(process)
        process.stderr.close()


@pytest.fixture(scope="session")
def large(tmp_path_factory):
    """2,000 runs: 2 scenarios, 20 groups each, 50 seeds, 200 generations."""
    out = tmp_path_factory.mktemp("large")
    random = np.random.default_rng(1)
    grid = itertools.product(("c-axis-ramp", "c-axis-step"), range(20))
    batch_folder(
        out,
        [
            (
                {"scenario": scenario, "search.population": 10 * k},
                random.lognormal(k, 2, 50).tolist(),
            )
            for scenario, k in grid
        ],
        generations=200,
    )
    assert hfc("report", out).exit_code == 0
    return out


SCORED = """
published = [
    { quantity = "w", value = 2e-3, metric = "max_error_rad", remark = "b", of = "weak" },
    { figure = "1", quantity = "a", value = 4.0, metric = "fitness", of = "strong", over = "weak" },
    { quantity = "one run", metric = "max_error_rad", of = "weak", over_metric = "rms_error_rad" },
    { quantity = "never", value = 1.0, metric = "settling_time_s", of = "weak" },
    { quantity = "median", value = 0.0, metric = "max_error_rad", of.scenario = "c-axis-ramp" },
]
[set]
simulation.duration_s = 0.2
[[cells]]
label = "weak"
scenario = "c-axis-ramp"
design = "pd-only"
change.controller.pd.kp = 400.0
[[cells]]
label = "strong"
scenario = "c-axis-ramp"
design = "pd-only"
[[cells]]
label = "cutting"
scenario = "c-axis-ramp-cutting"
design = "pd-only"
"""


@pytest.fixture(scope="session")
def scored(tmp_path_factory):
    """The folder of a batch that scores given designs; its file lies beside it."""
    path = tmp_path_factory.mktemp("scored")
    found = batch(written(path, SCORED), "--out", path / "out")
    assert found.exit_code == 0, found.output
    return path / "out"
