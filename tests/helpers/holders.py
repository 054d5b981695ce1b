"""Processes that hold the lock of a folder and write into it, to be killed, frozen and woken."""

import os
import subprocess
import sys
from contextlib import contextmanager

#: Writes NAME into the file "result" again and again, and says so; ends with what stopped it.
HOLDER = """
import sys, time
from pathlib import Path
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.lock import exclusive
from hfc_design.core.records import UserError
folder, name = Path(sys.argv[1]), sys.argv[2]
try:
    with exclusive(folder):
        while True:
            write_whole(folder / "result", name.encode())
            print("written", flush=True)
            time.sleep(0.01)
except UserError as error:
    print(error, flush=True)
"""


@contextmanager
def holder(folder, name, grace=60):
    """A process that has written once."""
    command = [sys.executable, "-c", HOLDER, str(folder), name]
    own = {**os.environ, "HFC_LOCK_GRACE_S": str(grace)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=own) as process:
        try:
            assert process.stdout.readline() == "written\n"
            yield process
        finally:
            process.kill()


def last_words(process):
    """What a holder said when it was stopped from writing."""
    return [line for line in process.stdout if line != "written\n"]
