"""What several files about batches share."""

import itertools
import subprocess
import sys

import numpy as np
import pytest
from batches import written
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
