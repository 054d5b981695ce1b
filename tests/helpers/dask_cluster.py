"""Schedulers and workers as processes of this machine, which tests may kill."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

import hfc_design

pytest.importorskip("distributed", reason="batches on a cluster need the package distributed")
psutil = pytest.importorskip("psutil", reason="comes with the package distributed")

#: Long enough that something can happen to a cell; the last one only scores a design. Gains are
#: searched, as each process makes its programs anew.
GRID = """
[set]
controller.kind = "pd"
search.population = 16
search.generations = 200
simulation.duration_s = 0.1
[grid]
scenario = ["c-axis-ramp", "c-axis-ramp-cutting"]
run.seed = [0, 1]
[[cells]]
"""
SCORED = """
[[cells]]
scenario = "c-axis-ramp"
design = "pd-only"
simulation.duration_s = 0.1
change.controller.pd.kp = 700.0
"""
GRID += SCORED
PATIENCE = 120.0
#: The package that is tested, also for processes in other folders.
ROOT = str(Path(hfc_design.__file__).parents[1])
PATHS = [ROOT, *filter(None, [os.environ.get("PYTHONPATH")])]
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(PATHS)}


def until(true, *, what):
    """Wait for something that has to happen."""
    end = time.monotonic() + PATIENCE
    while not (found := true()):
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.02)
    return found


def killed(process):
    if process.poll() is None:
        process.kill()
    process.wait(timeout=PATIENCE)


class Cluster:
    """A scheduler and its workers, which are put back when they have gone.

    ``path`` is their current folder; with ``tls`` options they hear only who has a key.
    """

    def __init__(self, path, *tls, count=2):
        self.path, self.tls, self.count = path, tls, count
        self._scheduler = None
        self.workers = []

    def __enter__(self):
        return self

    def __exit__(self, *error):
        for process in (*self.workers, self._scheduler):
            killed(process)

    def up(self):
        """Address of the scheduler, once everything runs."""
        if self._scheduler is None or self._scheduler.poll() is not None:
            for worker in self.workers:
                killed(worker)  # of a scheduler that is gone
            address = ["--port=0", f"--host={'tls' if self.tls else 'tcp'}://127.0.0.1"]
            self._scheduler = self._begun("scheduler", *address)
        said = r"Scheduler at:\s*(\w+://\S+)"
        address = until(lambda: self._said("scheduler", said), what="it")
        self.workers = [worker for worker in self.workers if worker.poll() is None]
        while len(self.workers) < self.count:
            self.workers.append(self._begun("worker", address, "--nthreads=1", "--no-nanny"))
        return address

    def lose_scheduler(self):
        killed(self._scheduler)

    def _begun(self, what, *arguments):
        command = [sys.executable, "-m", f"distributed.cli.dask_{what}", *arguments, *self.tls]
        folder = ["--local-directory", str(self.path)] if what == "worker" else []
        place = {"cwd": self.path, "env": ENVIRONMENT}
        with (self.path / f"{what}.log").open("wb" if what == "scheduler" else "ab") as log:
            return subprocess.Popen(
                [*command, *folder, "--dashboard-address=:0"],
                stdout=log,
                stderr=log,
                **place,
            )

    def _said(self, what, pattern):
        found = re.search(pattern, (self.path / f"{what}.log").read_text())
        return found and found[1]


def ended(process):
    """(exit code, what it said that is not a line of progress)."""
    said = process.communicate(timeout=PATIENCE)[1]
    return process.returncode, [
        line for line in said.splitlines() if line.split()[0] not in ("cell", "waiting")
    ]


def first_finished(out):
    """Wait for a finished cell: from then on the workers are in the middle of others."""
    until(lambda: list(out.glob("*/design.json")), what="a finished cell")


def alive(process):
    try:
        return process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
