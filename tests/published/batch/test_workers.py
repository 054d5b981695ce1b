"""What a worker takes of its machine, and worker processes that cannot be had."""

import os
import subprocess
import sys
import uuid

from dask_cluster import PATIENCE

SHARE = """
import os, sys, threading
from hfc_design.batch import worker
worker.CLAIM = sys.argv[1]
worker.gpus = lambda: ["7"]
threading.Thread(target=threading.Event().wait, daemon=True).start()
worker.take_share(1)
places = {tuple(os.sched_getaffinity(int(task))) for task in os.listdir("/proc/self/task")}
names = "CUDA_VISIBLE_DEVICES", "JAX_PLATFORMS", "JAX_NUM_CPU_DEVICES"
print(places, *map(os.environ.get, names), "jax" in sys.modules, flush=True)
sys.stdin.read()
"""


def test_workers_share_the_cores_of_a_machine():
    """Each has a core of its own, in all its threads, before JAX counts them; one has the GPU."""
    cores = sorted(os.sched_getaffinity(0))
    names = "CUDA_VISIBLE_DEVICES", "JAX_PLATFORMS", "JAX_NUM_CPU_DEVICES"
    plain = {name: value for name, value in os.environ.items() if name not in names}
    command = [sys.executable, "-c", SHARE, uuid.uuid4().hex]  # beside what really runs here
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": plain}
    processes, said = [], []
    try:
        for _ in range(len(cores) + 1):  # one more than there are cores
            processes.append(subprocess.Popen(command, **pipes))
            said.append(processes[-1].stdout.readline().strip())
    finally:
        for process in processes:
            process.communicate(timeout=PATIENCE)
    first, *others = [f"{{({core},)}}" for core in cores]
    assert said == [
        f"{first} 7 None None False",
        *(f"{core} None cpu None False" for core in others),
        f"{{{tuple(cores)}}} None cpu 2 False",
    ]
