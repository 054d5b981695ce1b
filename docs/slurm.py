"""Run a batch on workers that are Slurm jobs: python slurm.py mine.toml --out DIR --shared."""

import subprocess
import sys

from dask_jobqueue import SLURMCluster

if __name__ == "__main__":
    with SLURMCluster(
        queue="normal",  # partition
        walltime="01:00:00",
        cores=2,  # of one job, which is one worker
        processes=1,
        memory="4 GB",
        worker_extra_args=["--lifetime", "55m"],  # leave before Slurm ends the job
    ) as cluster:
        cluster.adapt(minimum_jobs=16, maximum_jobs=16)  # new ones for those that have left
        hfc = [sys.executable, "-m", "hfc_design", "batch", *sys.argv[1:]]
        sys.exit(subprocess.call([*hfc, "--scheduler", cluster.scheduler_address]))
