"""Runs the cells of a batch on worker processes, here or on other machines, through Dask.

A worker gets a cell as data: the path of the batch's folder if the worker can access it, else the
files of the cell's run folder; and references to the user's own plug-ins from the command line.
"""

import asyncio
import logging
import uuid
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from hfc_design import __version__
from hfc_design.batch.plan import Cell
from hfc_design.batch.runner import PATIENCE, Lost, Outcome, Place, Tls, unfinished
from hfc_design.core.numbers import Json, cores
from hfc_design.core.plugins import given
from hfc_design.core.records import RunError, UserError, checked, option

try:
    import dask
    from dask.utils import parse_timedelta
    from distributed import Client, Future, LocalCluster, wait
    from distributed.comm.core import connect
    from distributed.security import Security

    from hfc_design.batch.worker import contents, gpus, run_cell
except ImportError:
    raise UserError(
        f"{option('workers')} and --scheduler need the package distributed: "
        "pip install 'hfc-design[cluster]'"
    ) from None


#: Timeout of the connection to a scheduler.
ANSWER_WITHIN = "10s"
#: Formats in which results may arrive: they are parsed and never unpickled.
PLAIN = ["dask", "msgpack"]
#: Settings of Dask's web servers, which would be open to every user of this machine.
PAGES = "distributed.scheduler.http.routes", "distributed.worker.http.routes"
#: The run of a cell on a worker.
Task = Future[Json]


class Workers(Place):
    """Worker processes that each run one cell at a time; ``on_count`` gets the number of workers.

    Raises:
        Lost: by every method, if the connection to the scheduler is lost.
    """

    def __init__(self, client: Client, sees_folder: bool, on_count: Callable[[int], None]):
        self._client, self.claims, self._on_count = client, sees_folder, on_count

    def room(self) -> int:
        """Number of workers."""
        with self._reached():
            workers = len(self._client.nthreads())
        self._on_count(workers)
        return workers

    def start(self, cell: Cell, path: Path) -> Task:
        """Send the batch's path, or the files of the cell, to a worker; return the task."""
        where, files = (str(path.parent.resolve()), {}) if self.claims else ("", contents(path))
        sent = (__version__, cell.name, where, files, given(), self.anyway)
        with self._reached():
            key = f"{cell.name}-{uuid.uuid4().hex}"
            return self._client.submit(run_cell, *sent, key=key, pure=False)

    def done(self, tasks: Collection[Task]) -> Iterator[tuple[Task, Outcome]]:
        """Wait up to ``PATIENCE`` seconds for a task to end; yield ended tasks with outcomes."""
        if not tasks:
            return
        with self._reached():
            try:
                finished = wait(list(tasks), timeout=PATIENCE, return_when="FIRST_COMPLETED").done
            except TimeoutError:
                return
            for task in finished:
                try:
                    yield task, checked(Outcome, task.result(), "what it sent", Path())
                except (CancelledError, OSError):
                    raise
                except Exception as error:  # its workers all died, or lack hfc-design
                    yield task, unfinished(error, "on a worker: ")

    @contextmanager
    def _reached(self) -> Iterator[None]:
        lost = Lost("lost the connection to the scheduler; run the same command again to continue")
        try:
            yield
        except (CancelledError, OSError):
            raise lost from None
        if self._client.status != "running":
            raise lost


@contextmanager
def connected(
    workers: int | None,
    scheduler: str | None,
    shared: bool,
    tls: Tls,
    on_count: Callable[[int], None],
) -> Iterator[Workers]:
    """Start ``workers`` processes, or connect to those of ``scheduler`` (``shared``: on our disk).

    Raises:
        UserError: the number of workers, the address or the certificates are not valid.
        RunError: no scheduler answers.
    """
    for name in ("distributed", "distributed.client", "distributed.nanny"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)  # we report it ourselves
    dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 GiB"})
    if scheduler is None:
        assert workers is not None
        with _local(workers) as cluster, Client(cluster, deserializers=PLAIN) as client:
            yield Workers(client, True, on_count)
        return
    security = Security()
    if any(tls):
        scheduler = scheduler if "://" in scheduler else f"tls://{scheduler}"
        security = _security(scheduler, tls)
    try:
        with ThreadPoolExecutor(1) as pool:  # in a notebook this thread has an event loop
            pool.submit(asyncio.run, _answer(scheduler, security)).result()
        client = Client(scheduler, timeout=ANSWER_WITHIN, deserializers=PLAIN, security=security)
    except TypeError:
        raise UserError(f"--scheduler {scheduler}: needs --tls-ca, --tls-cert, --tls-key") from None
    except ValueError as error:
        raise UserError(
            f"--scheduler {scheduler}: must be an address such as tcp://HOST:PORT ({error})"
        ) from None
    except OSError:
        known = " that knows these certificates" if any(tls) else ""
        raise RunError(
            f"--scheduler {scheduler}: no scheduler{known} answers at this address"
        ) from None
    with client:
        yield Workers(client, shared, on_count)


async def _answer(scheduler: str, security: Security) -> None:
    """Connect to a scheduler once, to find out within a limited time whether it answers.

    A Client does not limit the time of its handshake, and leaves a thread behind if this fails.
    """
    timeout = parse_timedelta(ANSWER_WITHIN)
    connection = security.get_connection_args("client")
    comm = await asyncio.wait_for(connect(scheduler, timeout, **connection), timeout)
    await comm.close()


def _security(scheduler: str, tls: Tls) -> Security:
    ca, certificate, key = map(str, tls)
    if not scheduler.startswith("tls://"):
        raise UserError(f"--scheduler {scheduler}: must be tls://HOST:PORT with --tls-ca")
    security = Security(True, tls_ca_file=ca, tls_client_cert=certificate, tls_client_key=key)
    try:
        security.get_connection_args("client")
    except OSError as error:
        options = f"--tls-ca {ca}, --tls-cert {certificate}, --tls-key {key}"
        raise UserError(f"{options}: {error}") from None
    return security


def _local(workers: int) -> LocalCluster:
    """Start local workers, which accept only connections with a new key that is kept in memory."""
    free, cards = cores(), len(gpus())
    if workers > (cards or free):
        most = f"{cards or free}, one for each {'GPU' if cards else 'core'}"
        raise UserError(f"{option('workers', workers)}: must be at most {most}")
    try:
        security = Security.temporary()
    except ImportError:
        needed = "needs the package cryptography: pip install 'hfc-design[cluster]'"
        raise UserError(f"{option('workers')} {needed}") from None
    dask.config.set({key: [] for key in PAGES})
    return LocalCluster(
        n_workers=workers,
        threads_per_worker=max(free // workers, 1),
        processes=True,
        memory_limit=0,
        protocol="tls://",
        security=security,
        dashboard_address="127.0.0.1:0",
        silence_logs=logging.CRITICAL + 1,
        preload="hfc_design.batch.worker",
    )
