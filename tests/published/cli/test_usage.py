"""Command lines that cannot be: one line with what is allowed, exit code 2."""

import subprocess
import sys

from run_folders import hfc


def test_a_rate_of_learning_is_bounded():
    done = hfc("train", "huang-soc", "--network", "rate=1e12", "--passes", "1")
    told = "hfc: --network: rate = 1000000000000.0: must be at most 1000000\n"
    assert (done.exit_code, done.stderr) == (2, told)


def test_a_page_of_an_experiment_tells_mistakes_in_a_line_too():
    for arguments in (["--identified", "missing.toml"], ["--machines", "x"]):
        call = [sys.executable, "-m", "experiments.emps.page", *arguments]
        done = subprocess.run(call, capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert done.stderr.startswith("hfc: ")
        assert done.stderr.count("\n") == 1
