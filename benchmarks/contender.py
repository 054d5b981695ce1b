"""One contender in a process of its own, so that its memory and its set-up of JAX are its own.

The runner starts ``python contender.py NAME WORK SCORES`` and then asks for a turn or for the
peak memory, a line each; every answer is a line of JSON.
"""

import importlib
import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from c_peer import WIDE
from work import load

#: Name -> (module, options of its ``prepare``).
CONTENDERS: dict[str, tuple[str, dict[str, Any]]] = {
    "evaluator": ("evaluator_peer", {}),
    "C": ("c_peer", {}),
    "C, 512 bit": ("c_peer", {"flags": (WIDE,)}),
    "C, 512 bit, own exp": ("c_peer", {"flags": (WIDE, "-DOWN_EXP")}),
    "vmap of einsum": ("einsum_peer", {}),
    "diffrax": ("diffrax_peer", {}),
    "numpy": ("numpy_peer", {}),
}

#: A turn repeats the run for about this time, so that a hiccup of the machine weighs little.
TURN_S = 0.15

#: Without a cache of compiled programs, so that the compile time is one.
ENVIRONMENT = {"JAX_PLATFORMS": "cpu", "JAX_ENABLE_COMPILATION_CACHE": "false"}


class Start(NamedTuple):
    """What a contender tells when it is ready for its first turn."""

    prepare_s: float  # mostly compilation
    run_s: float  # the first run after it
    imported_bytes: int  # peak resident memory once everything is imported


class Contender:
    """The runner's side: a child process to be given turns."""

    def __init__(self, name: str, work: Path) -> None:
        scores = work.with_suffix(".npy")
        self.name = name
        self._child = subprocess.Popen(
            [sys.executable, __file__, name, work, scores],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | ENVIRONMENT,
        )
        self.start = Start(*self._answer())
        self.scores = np.load(scores)

    def turn(self) -> float:
        """Seconds of one run."""
        return float(self._asked("turn"))

    def peak_bytes(self) -> int:
        """Peak resident memory so far."""
        return int(self._asked("peak"))

    def close(self) -> None:
        """End the child."""
        self._child.communicate()

    def _asked(self, question: str) -> Any:
        assert self._child.stdin
        print(question, file=self._child.stdin, flush=True)
        return self._answer()

    def _answer(self) -> Any:
        assert self._child.stdout
        line = self._child.stdout.readline()
        if not line:
            raise RuntimeError(f"contender {self.name} ended with {self._child.wait()}")
        return json.loads(line)


def main(name: str, work: str, scores: str) -> None:
    """The child's side."""
    module, options = CONTENDERS[name]
    peer = importlib.import_module(module)
    imported = peak_memory()
    given = load(Path(work))
    begin = time.perf_counter()
    run = peer.prepare(given, **options)
    prepared = time.perf_counter()
    found = run()
    start = Start(prepared - begin, time.perf_counter() - prepared, imported)
    np.save(scores, found)
    answer(start)
    runs = max(1, int(TURN_S / start.run_s))
    for question in sys.stdin:
        answer(peak_memory() if question.strip() == "peak" else seconds(run, runs))


def answer(value: Any) -> None:
    """One line of JSON to the runner."""
    print(json.dumps(value), flush=True)


def seconds(run: Callable[[], np.ndarray], runs: int) -> float:
    """Mean time of ``runs`` runs."""
    begin = time.perf_counter()
    for _ in range(runs):
        run()
    return (time.perf_counter() - begin) / runs


def processor() -> str:
    """Name of the processor."""
    lines = Path("/proc/cpuinfo").read_text(encoding="ascii").splitlines()
    models = [line.split(": ")[1] for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()


def peak_memory() -> int:
    """Peak resident memory of this process [bytes].

    Not ``ru_maxrss``: a child inherits that from the process that started it.
    """
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return 1024 * int(status.split("VmHWM:")[1].split()[0])


if __name__ == "__main__":
    main(*sys.argv[1:])
