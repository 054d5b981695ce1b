"""A worker process: it takes its share of the machine, then runs one cell at a time.

JAX counts the cores when it is imported; therefore modules that need it are imported only after
that share has been taken.
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
from typing import TYPE_CHECKING, Any

from distributed import Status, Worker, get_worker

from hfc_design import __version__
from hfc_design.core.lock import try_lock
from hfc_design.core.numbers import FEWEST_DEVICES, Json
from hfc_design.core.plugins import References, know
from hfc_design.core.records import UserError, in_a_line

if TYPE_CHECKING:
    from hfc_design.batch.runner import Outcome

#: Name of each file of a run folder -> its content.
Files = dict[str, bytes]
#: Prefix of the claims of cores and GPUs.
CLAIM = "hfc-design"

_alone = threading.Lock()  # a worker with many threads is given many cells
_taken: list[socket.socket] = []


def dask_setup(worker: Worker) -> None:
    """Ignore Ctrl-C, which a terminal sends to every process; the batch handles it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def answer(*cell: Any) -> Json:
    """Outcome of ``run_cell`` as plain data that is read without pickle."""
    return run_cell(*cell).model_dump()


def run_cell(
    version: str, name: str, shared: str, files: Files, plugins: References, anyway: bool
) -> "Outcome":
    """Finish a cell: in the folder ``shared`` of the batch, or from and to ``files``.

    ``plugins`` are those named on the command line of the batch; those of earlier cells are
    forgotten. ``anyway`` continues runs that other versions began.
    """
    worker = get_worker()
    key = worker.get_current_task()
    with _alone:
        take_share(worker.state.nthreads)
        from hfc_design.batch import runner  # with it comes every group of plug-ins
        from hfc_design.runs import run as design

        def go_on(search: object) -> None:
            task = worker.state.tasks.get(key)
            running = task is not None and task.state in ("executing", "long-running")
            if not running or worker.status not in (Status.running, Status.paused):
                raise runner.Left

        def finish(path: Path) -> None:
            go_on(None)  # it may have waited for long
            with _of_this_worker():  # a package that the batch has may be missing
                scenario = design.opened_run(path)
            design.run(scenario, path, go_on, anyway, go_on)

        if version != __version__:
            versions = f"has hfc-design {__version__}, the batch {version}"
            return _failed(f"the worker {worker.address} {versions}")
        try:
            with _of_this_worker("; install the module there, or start the worker in its folder"):
                know(plugins)
            if shared:
                return run_in(Path(shared), name, finish)
            with TemporaryDirectory(dir=worker.local_directory) as place:
                return _run_sent(Path(place) / name, files, finish)
        except Exception as error:  # a full disk, for one; the worker may run other cells
            return runner.unfinished(error)


@contextmanager
def _of_this_worker(hint: str = "") -> Iterator[None]:
    """Add this worker's name to error messages, since the batch may not have the problem."""
    try:
        yield
    except UserError as error:
        worker = get_worker()
        place = f"the worker {worker.address} on {socket.gethostname()}"
        why = str(error.args[0]).replace(f"{worker.local_directory}{os.sep}", "")  # of nobody's use
        raise UserError(f"{place}: {why}{hint}") from error


def run_in(out: Path, name: str, finish: Callable[[Path], None]) -> "Outcome":
    """Finish a cell in the folder of its batch, unless another process is running it."""
    from hfc_design.batch import folder
    from hfc_design.batch.runner import Outcome, attempt
    from hfc_design.files.labels import PLAN

    if not (out / PLAN).exists():
        host = socket.gethostname()
        return _failed(f"{out}: the worker on {host} does not see this folder; see --shared")
    with try_lock(out / name) as mine:
        if not mine:
            return Outcome(state="again")
        if folder.state(out, name) == "finished":
            return Outcome(state="finished")
        return attempt(lambda: finish(out / name))


def _run_sent(path: Path, files: Files, finish: Callable[[Path], None]) -> "Outcome":
    from hfc_design.batch.runner import attempt

    path.mkdir()
    for name, content in files.items():
        (path / name).write_bytes(content)
    outcome = attempt(lambda: finish(path))  # if it fails, what it has written is sent all the same
    written = {name: x for name, x in contents(path).items() if files.get(name) != x}
    return outcome.model_copy(update={"files": written})


def _failed(reason: str) -> "Outcome":
    from hfc_design.batch.runner import Outcome

    return Outcome(state="failed", reason=in_a_line(reason))


def contents(path: Path) -> Files:
    """Files of a run, without its lock and half-written files of a killed process."""
    files = (file for file in path.iterdir() if file.is_file() and file.suffix != ".new")
    return {file.name: file.read_bytes() for file in files if file.name[0] != "."}


@cache
def take_share(cores: int) -> None:
    """Bind this process to cores, and to a GPU if there are any, that no other worker has."""
    if indices := gpus():
        if card := _free("gpu", indices, 1):
            os.environ["CUDA_VISIBLE_DEVICES"] = card[0]
        else:  # more workers than GPUs, and two would not get on in the memory of one
            os.environ["JAX_PLATFORMS"] = "cpu"
    share = _free("core", [str(core) for core in sorted(os.sched_getaffinity(0))], cores)
    if not share:  # more workers than cores: the system shares them out
        few = max(FEWEST_DEVICES, cores)
        os.environ.setdefault("JAX_NUM_CPU_DEVICES", str(few))
        return
    for thread in os.listdir("/proc/self/task"):  # later ones inherit it from these
        with suppress(ProcessLookupError):  # it has ended
            os.sched_setaffinity(int(thread), map(int, share))


def gpus() -> list[str]:
    """GPUs that JAX may use, as named in CUDA_VISIBLE_DEVICES."""
    if not entry_points(group="jax_plugins") or os.environ.get("JAX_PLATFORMS", "cuda") == "cpu":
        return []
    allowed = os.environ.get("CUDA_VISIBLE_DEVICES")
    if allowed is not None:
        return [name for name in allowed.split(",") if name]
    return [str(k) for k, _ in enumerate(Path("/dev").glob("nvidia[0-9]*"))]


def _free(kind: str, names: Sequence[str], count: int) -> list[str]:
    """Reserve up to ``count`` of the names on this machine for the lifetime of this process.

    A socket name outside the file system can be bound once, and the system releases it when the
    process ends, however it ends.
    """
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
