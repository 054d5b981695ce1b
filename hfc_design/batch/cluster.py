"""Running the cells of a batch on worker processes, here or on other machines, through Dask.

A cell goes to a worker as data: the files of its run folder, or the folder that both see, and the
references to own plug-ins that the command line gave.
"""

import logging
import os
import time
import uuid
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from pathlib import Path

from hfc_design import __version__
from hfc_design.batch import folder, work
from hfc_design.batch.plan import Cell
from hfc_design.batch.work import PATIENCE, Outcome
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.plugins import given
from hfc_design.core.records import RunError, UserError
from hfc_design.runs import run as design

try:
    import dask
    from distributed import Client, Future, LocalCluster, wait

    from hfc_design.batch.worker import Result, contents, gpus, run_cell
except ImportError:
    raise UserError(
        "--workers and --scheduler need the package distributed: pip install 'hfc-design[cluster]'"
    ) from None


#: How long a scheduler is waited for.
ANSWER_WITHIN = "10s"
#: A cell's run on a worker, the cell, and our claim of it unless the worker has it.
Task = Future[Result]
Running = tuple[Cell, ExitStack]


@contextmanager
def connected(workers: int | None, scheduler: str | None) -> Iterator[Client]:
    """Workers to be used: ``workers`` processes of our own, or those of a scheduler.

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
            yield client
        return
    try:
        client = Client(scheduler, timeout=ANSWER_WITHIN)
    except ValueError as error:
        raise UserError(f"--scheduler {scheduler}: {error}") from None
    except OSError:
        raise RunError(f"--scheduler {scheduler}: no scheduler answers there") from None
    with client:
        yield client


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


def run_cells(
    client: Client,
    out: Path,
    cells: Sequence[Cell],
    on_outcome: Callable[[Outcome], None],
    on_workers: Callable[[int], None],
    shared: bool,
) -> None:
    """Finish every cell that is not, as many at once as there are workers.

    Args:
        on_workers: is told now and then how many workers there are.
        shared: the workers see ``out`` under the same path and write into it.

    Raises:
        RunError: the scheduler is lost, or the folder of the batch cannot be written.
    """
    waiting, busy = list(reversed(cells)), list[Cell]()
    running: dict[Task, Running] = {}
    try:
        while waiting or busy or running:
            if not waiting:
                waiting, busy = busy[::-1], []
            with _reaching(client):
                workers = len(client.nthreads())
            on_workers(workers)
            while waiting and len(running) < workers:
                cell = waiting.pop()
                found = _sent(client, out, cell, shared)
                if isinstance(found, Outcome):
                    on_outcome(found)
                elif found is None:
                    busy.append(cell)
                else:
                    task, running[task] = found
            for task in _done(client, running):
                cell, claim = running.pop(task)
                with claim:
                    outcome = _settled(client, out, cell, task)
                if outcome is None:
                    busy.append(cell)
                else:
                    on_outcome(outcome)
    finally:
        for _, claim in running.values():
            claim.close()


def _sent(
    client: Client, out: Path, cell: Cell, shared: bool
) -> tuple[Task, Running] | Outcome | None:
    """A cell on its way to a worker; its outcome if there is one; None if another batch has it."""
    if folder.state(out, cell.name) == "finished":
        return Outcome(cell, "finished")
    path = out / cell.name
    with ExitStack() as claim:
        if not claim.enter_context(folder.claimed(out, cell.name)):
            return None
        if folder.state(out, cell.name) == "finished":  # by another batch, since we looked
            return Outcome(cell, "finished")
        folder.forget_failure(out, cell.name)
        try:
            work.begun(cell, path)
            files = {} if shared else contents(path)
        except Exception as error:  # whatever it is, the other cells may still be fine
            return work.failed(out, cell, work.told(error))
        kept = ExitStack() if shared else claim.pop_all()
    where = str(out.resolve()) if shared else ""
    key = f"{cell.name}-{uuid.uuid4().hex}"
    with _reaching(client):
        sent = (__version__, cell.name, where, files, given())
        task = client.submit(run_cell, *sent, key=key, pure=False)
    return task, (cell, kept)


def _done(client: Client, running: Iterable[Task]) -> Iterable[Task]:
    """The tasks that are done; waits a little for the first one."""
    if not running:
        time.sleep(PATIENCE)
        return ()
    with _reaching(client):
        try:
            return wait(list(running), timeout=PATIENCE, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            return ()


def _settled(client: Client, out: Path, cell: Cell, task: Task) -> Outcome | None:
    """What became of a cell whose task is done; None if it has to be tried again."""
    with _reaching(client):
        try:
            state, reason, seconds, files = task.result()
        except (CancelledError, OSError):
            raise
        except Exception as error:  # killed each time, or no hfc-design on the worker
            return work.failed(out, cell, f"on a worker: {work.told(error)}")
    try:
        for name in sorted(files, key=lambda name: name == design.DESIGN):  # what finishes it last
            write_whole(out / cell.name / name, files[name])
    except RunError as error:
        return work.failed(out, cell, work.told(error))
    if state == "again":
        return None
    if state == "failed":
        return work.failed(out, cell, reason)
    if not seconds:  # another batch has finished it
        return Outcome(cell, "finished")
    return work.finished(out, cell, seconds)


@contextmanager
def _reaching(client: Client) -> Iterator[None]:
    lost = RunError("the scheduler is lost; the same command goes on where the batch stopped")
    try:
        yield
    except (CancelledError, OSError):
        raise lost from None
    if client.status != "running":
        raise lost
