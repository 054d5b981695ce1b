"""A worker process: it reserves cores, and a GPU if there is one, and runs one cell at a time.

JAX counts the cores when it is imported; therefore modules that need JAX are imported only after
the cores have been reserved.
"""

import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import psutil
from distributed import Status, Worker, get_worker

from hfc_design import __version__
from hfc_design.core.lock import try_lock
from hfc_design.core.numbers import FEWEST_DEVICES, Json
from hfc_design.core.plugins import References, know
from hfc_design.core.records import UserError, in_a_line
from hfc_design.files.labels import PLAN

if TYPE_CHECKING:
    from hfc_design.batch.runner import Outcome

#: Name of each file of a run folder -> its content.
Files = dict[str, bytes]
#: Prefix of the socket names that reserve cores and GPUs.
CLAIM = "hfc-design"

_alone = threading.Lock()  # Dask gives a cell to each thread of a worker
_taken: list[socket.socket] = []


def dask_setup(worker: Worker) -> None:
    """Ignore Ctrl-C, which a terminal sends to every process; the batch handles it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def run_cell(
    version: str, name: str, shared: str, files: Files, plugins: References, anyway: bool
) -> Json:
    """Run a cell in the folder ``shared`` of its batch or, if that is "", in a copy of ``files``.

    ``plugins`` are those named on the command line of the batch; plug-ins of earlier cells are
    removed. ``anyway`` continues runs that other versions of hfc-design began. The outcome is
    returned as plain data, which can be read without pickle.
    """
    worker = get_worker()
    key = worker.get_current_task()
    with _alone:
        take_share(worker.state.nthreads)
        from hfc_design.batch import runner  # imports every group of plug-ins
        from hfc_design.runs import run as design

        def go_on(search: object) -> None:
            task = worker.state.tasks.get(key)
            running = task is not None and task.state in ("executing", "long-running")
            if not running or worker.status not in (Status.running, Status.paused):
                raise runner.Left

        def finish(path: Path) -> None:
            go_on(None)  # the cell may have waited too long
            with _of_this_worker():  # where a package may be missing
                scenario = design.opened_run(path)
            design.run(scenario, path, go_on, anyway, go_on)

        try:
            if version != __version__:
                versions = f"has hfc-design {__version__}, the batch {version}"
                reason = in_a_line(f"the worker {worker.address} {versions}")
                return runner.Outcome(state="failed", reason=reason).model_dump()
            with _of_this_worker("; install the module there, or start the worker in its folder"):
                know(plugins)
            if shared:
                return run_in(Path(shared), name, finish).model_dump()
            with TemporaryDirectory(dir=worker.local_directory) as place:
                return _run_sent(Path(place) / name, files, finish).model_dump()
        except Exception as error:  # such as a full disk; other cells may still run
            return runner.unfinished(error).model_dump()


@contextmanager
def _of_this_worker(hint: str = "") -> Iterator[None]:
    """Add this worker's name to error messages, as only this worker may have the problem."""
    try:
        yield
    except UserError as error:
        worker = get_worker()
        place = f"the worker {worker.address} on {socket.gethostname()}"
        why = str(error.args[0]).replace(f"{worker.local_directory}{os.sep}", "")  # temporary
        raise UserError(f"{place}: {why}{hint}") from error


def run_in(out: Path, name: str, finish: Callable[[Path], None]) -> "Outcome":
    """Run a cell in the folder of its batch, unless another process is running it."""
    from hfc_design.batch import folder, runner

    if not (out / PLAN).exists():
        unseen = f"the worker on {socket.gethostname()} does not see this folder; see --shared"
        return runner.Outcome(state="failed", reason=in_a_line(f"{out}: {unseen}"))
    with try_lock(out / name) as mine:
        if not mine:
            return runner.Outcome(state="again")
        if folder.state(out, name) == "finished":
            return runner.Outcome(state="finished")
        return runner.attempt(lambda: finish(out / name))


def _run_sent(path: Path, files: Files, finish: Callable[[Path], None]) -> "Outcome":
    from hfc_design.batch.runner import attempt

    path.mkdir()
    for name, content in files.items():
        (path / name).write_bytes(content)
    outcome = attempt(lambda: finish(path))  # if this fails, files are sent too
    written = {name: x for name, x in contents(path).items() if files.get(name) != x}
    return outcome.model_copy(update={"files": written})


def contents(path: Path) -> Files:
    """Return the files of a run, without the lock and half-written files of a killed process."""
    files = (file for file in path.iterdir() if file.is_file() and file.suffix != ".new")
    return {file.name: file.read_bytes() for file in files if file.name[0] != "."}


@cache
def take_share(cores: int) -> None:
    """Bind this process to cores, and to a GPU if there is one, that no other worker uses."""
    if indices := gpus():
        if card := _free("gpu", indices, 1):
            os.environ["CUDA_VISIBLE_DEVICES"] = card[0]
        else:  # no GPU is left, and the memory of one is too small for two workers
            os.environ["JAX_PLATFORMS"] = "cpu"
    available = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    share = _free("core", [*map(str, available)], cores)
    if share and hasattr(os, "sched_setaffinity"):
        for thread in psutil.Process().threads():  # later threads inherit this
            with suppress(ProcessLookupError):  # the thread has ended
                os.sched_setaffinity(thread.id, map(int, share))
    else:  # more workers than cores, or not on Linux: they are not bound to any
        os.environ.setdefault("JAX_NUM_CPU_DEVICES", str(max(FEWEST_DEVICES, cores)))


def gpus() -> list[str]:
    """GPUs that JAX may use, as named in CUDA_VISIBLE_DEVICES."""
    if not entry_points(group="jax_plugins") or os.environ.get("JAX_PLATFORMS", "cuda") == "cpu":
        return []
    allowed = os.environ.get("CUDA_VISIBLE_DEVICES")
    if allowed is not None:
        return [name for name in allowed.split(",") if name]
    return [str(k) for k, _ in enumerate(Path("/dev").glob("nvidia[0-9]*"))]


def _free(kind: str, names: Sequence[str], count: int) -> list[str]:
    """Reserve and return up to ``count`` of ``names`` while this process runs on this machine.

    A name is reserved by a socket name outside the file system, which only one process can bind;
    the operating system releases it when the process ends for any reason.
    """
    if not hasattr(socket, "AF_UNIX"):  # Windows
        return []
    job = os.environ.get("SLURM_JOB_ID", "")  # each job counts its own GPUs from 0
    unused: list[str] = []
    for name in names:
        if len(unused) == count:
            break
        claim = socket.socket(socket.AF_UNIX)
        try:
            claim.bind(f"\0{CLAIM}-{job}-{kind}-{name}")
        except OSError:
            claim.close()
            continue
        _taken.append(claim)
        unused.append(name)
    return unused
