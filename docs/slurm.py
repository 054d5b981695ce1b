"""Run a batch on workers that are Slurm jobs: python slurm.py mine.toml --out DIR --shared."""

import subprocess
import sys

from dask_jobqueue import SLURMCluster

if __name__ == "__main__":
    with SLURMCluster(
        queue="normal",  # partition
        walltime="01:00:00",
        cores=8,  # of one job
        processes=4,  # workers in one job, here with two cores each
        memory="16 GB",  # of one job
        worker_extra_args=["--lifetime", "55m"],  # leave before Slurm ends the job
    ) as cluster:
        cluster.adapt(minimum_jobs=4, maximum_jobs=4)  # new ones for those that have left
        hfc = [sys.executable, "-m", "hfc_design", "batch", *sys.argv[1:]]
        sys.exit(subprocess.call([*hfc, "--scheduler", cluster.scheduler_address]))
