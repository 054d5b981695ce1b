"""JAX that has started before the package, or that was set up by the user."""

import os
import subprocess
import sys

import pytest

START = "import jax.numpy as j; j.zeros(3) + 1\n"
#: Of a PD controller, which compiles soonest.
SCORE = """
import hfc_design.api as hfc
where = hfc.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})
score = hfc.evaluate("pd-only", where).fitness
"""


def told(code, **variables):
    """Score that a program prints, and its warnings."""
    # Packages that are older than what they use warn of that.
    command = [sys.executable, "-W", "always", "-W", "ignore::DeprecationWarning"]
    command += ["-c", f"{code}{SCORE}print(repr(score))"]
    environment = {**os.environ, **variables}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout), done.stderr


@pytest.fixture(scope="module")
def usual():
    found = {}
    exec(SCORE, found)
    return found["score"]


def test_after_jax_has_started_it_works_with_one_warning(usual):
    score, warned = told(START)
    assert score == pytest.approx(usual, rel=1e-9)
    assert warned.count("UserWarning") == 1
    assert "import hfc_design.api before the first computation with JAX" in warned


def test_a_command_sets_jax_up_before_a_drive_computes():
    """The drives' own functions are called already when files are checked."""
    command = [sys.executable, "-m", "hfc_design", "score", "jee-koren-2004-flc"]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")  # where a warning would be


RACE = """
import hashlib
import numpy as np
from hfc_design import api
from hfc_design.runs.problem import Problem
task = Problem(api.load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1})).task
one = task.genome.fresh(np.zeros(1, int), np.random.default_rng(0))
linear = task.linearised(one)
bits = hashlib.md5(linear.error.tobytes() + linear.jacobian.tobytes()).hexdigest()
"""


def test_a_derivative_on_one_core_has_the_bits_of_many():
    here = {}
    exec(RACE, here)
    cores = sorted(os.sched_getaffinity(0))
    for some, variables in ((cores[:1], {}), (cores, {"JAX_NUM_CPU_DEVICES": "1"})):
        code = f"import os; os.sched_setaffinity(0, {some})\n{RACE}print(bits)"
        own = {"env": {**os.environ, **variables}, "capture_output": True, "text": True}
        done = subprocess.run([sys.executable, "-c", code], check=True, **own)
        assert (done.stdout.strip(), done.stderr) == (here["bits"], "")


@pytest.mark.parametrize(
    ("code", "variables"),
    [
        (
            "import jax; jax.config.update('jax_num_cpu_devices', 1)\n",
            {"JAX_PLATFORMS": "cpu", "JAX_ENABLE_X64": "0"},
        ),
        (
            "import jax; import hfc_design.api; jax.config.update('jax_enable_x64', False)\n",
            {"JAX_NUM_CPU_DEVICES": "2"},
        ),
    ],
)
def test_scores_are_of_float64_however_jax_was_set_up(code, variables, usual):
    score, warned = told(code, **variables)
    assert score == pytest.approx(usual, rel=1e-9)
    assert warned == ""


@pytest.mark.parametrize("platform", ["cuda-12-nope", "nonsense"])
def test_a_platform_that_is_not_there_is_one_line(platform):
    command = [sys.executable, "-m", "hfc_design", "score", "lin-lee-1999-table-1"]
    environment = {**os.environ, "JAX_PLATFORMS": platform}
    done = subprocess.run(command, check=False, env=environment, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith(f"hfc: JAX_PLATFORMS={platform}: JAX cannot start")
    assert done.stderr.count("\n") == 1
