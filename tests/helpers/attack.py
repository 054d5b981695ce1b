"""How hard attacks are, and what they note for docs/reliability.md.

``HFC_ATTACK=full`` is the attack of the page; without it each is small enough for every run of
the tests. ``HFC_ATTACK_SEED`` draws other inputs, ``HFC_ATTACK_LOG`` names a file that gets a
line of JSON from each attack.
"""

import json
import os
import resource
import time
from collections import Counter

SEED = int(os.environ.get("HFC_ATTACK_SEED", "0"))
FULL = os.environ.get("HFC_ATTACK") == "full"
#: Processor time and memory that one input may take: other programs run beside.
SECONDS, MEGABYTES = 10.0, 1000.0


def rounds(small: int, full: int) -> int:
    """How many inputs to try."""
    return full if FULL else small


def peak() -> float:
    """Memory that this process has held at most [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


class Attack:
    """Counts what came of every input, and the slowest; ``end`` asserts and notes it."""

    def __init__(self, name: str):
        self.name = name
        self.outcomes: Counter[str] = Counter()
        self.slowest, self._before = 0.0, peak()

    def input(self, outcome_of, *arguments) -> object:
        """Try one input: ``outcome_of`` gives a word for what came of it."""
        start = time.process_time()
        outcome = outcome_of(*arguments)
        self.slowest = max(self.slowest, time.process_time() - start)
        assert self.slowest < SECONDS, (self.name, self.slowest, arguments)
        self.outcomes[str(outcome)] += 1
        return outcome

    def end(self, **more: object) -> None:
        """Nothing took more memory than is allowed; note what was tried."""
        grown = peak() - self._before
        assert grown < MEGABYTES, (self.name, grown)
        tried = {"attack": self.name, "tried": self.outcomes.total(), "seed": SEED}
        measured = {"slowest_s": round(self.slowest, 3), "memory_mb": round(grown, 1)}
        note({**tried, "outcomes": dict(self.outcomes), **measured, **more})


def note(line: dict) -> None:
    """Add a line to the log, if there is one."""
    if log := os.environ.get("HFC_ATTACK_LOG"):
        with open(log, "a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
