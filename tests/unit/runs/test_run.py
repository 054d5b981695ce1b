"""Run folders that are none, and files that cannot be written."""

import resource
import signal

from short_runs import started
from wording import refused

from hfc_design.core import checkpoint
from hfc_design.core.records import RunError
from hfc_design.runs import run as design


def test_folder_without_a_run_cannot_be_resumed(tmp_path):
    with refused() as found:
        design.opened_run(tmp_path)
    assert found.where == f"folder='{tmp_path}'"


def test_full_disk_loses_nothing(tmp_path):
    """A limit on the size of files stands for the full disk: the same OSError, really raised."""
    path = tmp_path / "file"
    checkpoint.write_whole(path, b"old" * 100)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with refused(RunError):
            checkpoint.write_whole(path, b"new" * 1000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == b"old" * 100


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with refused(RunError):
        started(tmp_path / "file" / "run")
