"""Running the cells of a batch on worker processes, here or on other machines, through Dask.

A cell goes to a worker as data: the files of its run folder, or the folder that both see, and the
references to own plug-ins that the command line gave.
"""

import logging
import os
import uuid
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from pathlib import Path

from hfc_design import __version__
from hfc_design.batch.plan import Cell
from hfc_design.batch.work import PATIENCE, Lost, Outcome, Place, told
from hfc_design.core.plugins import given
from hfc_design.core.records import RunError, UserError

try:
    import dask
    from distributed import Client, Future, LocalCluster, wait

    from hfc_design.batch.worker import contents, gpus, run_cell
except ImportError:
    raise UserError(
        "--workers and --scheduler need the package distributed: pip install 'hfc-design[cluster]'"
    ) from None


#: How long a scheduler is waited for.
ANSWER_WITHIN = "10s"
#: A cell's run on a worker.
Task = Future[Outcome]


class Workers(Place):
    """Worker processes, each with one cell at a time; ``on_count`` is told how many there are.

    Raises:
        Lost: by every method, if the scheduler is.
    """

    def __init__(self, client: Client, sees_folder: bool, on_count: Callable[[int], None]):
        self._client, self.claims, self._on_count = client, sees_folder, on_count

    def room(self) -> int:
        """As many as there are workers."""
        with self._reached():
            workers = len(self._client.nthreads())
        self._on_count(workers)
        return workers

    def start(self, cell: Cell, path: Path) -> Task:
        """Send the cell: the folder of the batch, or what is in its own."""
        where, files = (str(path.parent.resolve()), {}) if self.claims else ("", contents(path))
        sent = (__version__, cell.name, where, files, given(), self.anyway)
        with self._reached():
            key = f"{cell.name}-{uuid.uuid4().hex}"
            return self._client.submit(run_cell, *sent, key=key, pure=False)

    def done(self, tasks: Collection[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Wait for the first one; what leaves no worker alive to tell of it has failed."""
        if not tasks:
            return
        with self._reached():
            try:
                found = wait(list(tasks), timeout=PATIENCE, return_when="FIRST_COMPLETED").done
            except TimeoutError:
                return
            for task in found:
                try:
                    yield task, Outcome(*task.result())
                except (CancelledError, OSError):
                    raise
                except Exception as error:  # killed each time, or no hfc-design on the worker
                    yield task, Outcome("failed", f"on a worker: {told(error)}")

    @contextmanager
    def _reached(self) -> Iterator[None]:
        lost = Lost("the scheduler is lost; the same command goes on where the batch stopped")
        try:
            yield
        except (CancelledError, OSError):
            raise lost from None
        if self._client.status != "running":
            raise lost


@contextmanager
def connected(
    workers: int | None, scheduler: str | None, shared: bool, on_count: Callable[[int], None]
) -> Iterator[Workers]:
    """``workers`` processes of our own, or those of a scheduler, which may share our disk.

    Raises:
        UserError: so many workers, or such an address, cannot be.
        RunError: no scheduler answers.
    """
    for name in ("distributed", "distributed.client", "distributed.nanny"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what happens is ours to tell
    dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 GiB"})
    if scheduler is None:
        assert workers is not None
        with _local(workers) as cluster, Client(cluster) as client:
            yield Workers(client, True, on_count)
        return
    try:
        client = Client(scheduler, timeout=ANSWER_WITHIN)
    except ValueError as error:
        raise UserError(f"--scheduler {scheduler}: {error}") from None
    except OSError:
        raise RunError(f"--scheduler {scheduler}: no scheduler answers there") from None
    with client:
        yield Workers(client, shared, on_count)


def _local(workers: int) -> LocalCluster:
    cores, cards = len(os.sched_getaffinity(0)), len(gpus())
    if workers > (cards or cores):
        there = f"{cards} GPUs" if cards else f"{cores} cores"
        raise UserError(f"--workers {workers}: there are {there}, and each worker needs one")
    return LocalCluster(
        n_workers=workers,
        threads_per_worker=max(cores // workers, 1),
        processes=True,
        memory_limit=0,
        dashboard_address="127.0.0.1:0",
        silence_logs=logging.CRITICAL,
        preload="hfc_design.batch.worker",
    )
