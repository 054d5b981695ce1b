"""What users read where something is refused, all of it in one file: tests/wording.txt.

A test says what is refused and which key, file or option the line is about. The line itself is
compared with the file, which ``make wording`` writes anew: read its difference.
"""

import linecache
import os
import re
from collections import defaultdict

from click.testing import CliRunner
from places import TESTS

from hfc_design.cli import main
from hfc_design.core.records import UserError

FILE = TESTS / "wording.txt"
#: What becomes of the lines: "compare" or "write"; "any" with packages that word or name theirs
#: otherwise.
ASKED = os.environ.get("HFC_WORDING", "compare")
#: Folders that are another one each time, or on each machine, and what hangs on them.
PLACES = [
    (re.compile(r"/\S*?/pytest-of-\S+?/pytest-\d+/(?:popen-gw\d+/)?[^/\s:'\"]+"), "TMP"),
    (re.compile(re.escape(str(TESTS.parent))), "ROOT"),
    # Where a long line is cut, and whether it is, hangs on the length of these.
    (re.compile(r"^(.{100}).* \.\.\. .*$", re.MULTILINE), r"\1 ..."),
    (re.compile(r"^(?=.*(?:TMP|ROOT))(.{100}).{90,}$", re.MULTILINE), r"\1 ..."),
]
#: Test -> what was said in it, entry by entry.
SAID: dict[str, list[str]] = defaultdict(list)


class Refusal(str):
    """The lines that a user reads, and what they are about."""

    @property
    def where(self) -> str:
        """What the first line begins with: a file and its line, a key, an option."""
        line = self.removeprefix("hfc: ").splitlines()[0]
        return re.split(r": (?!line \d)| = ", line, maxsplit=1)[0]


class Raised:
    """A context in which an error has to be raised; its ``error`` and the ``refusal``."""

    error: BaseException
    refusal: Refusal

    def __init__(self, kind: type[BaseException]):
        self.kind = kind

    def __enter__(self) -> "Raised":
        return self

    def __exit__(self, kind, error, trace) -> bool:
        assert error is not None, f"nothing was raised, not even {self.kind.__name__}"
        if not isinstance(error, self.kind):
            return False
        call = linecache.getline(trace.tb_frame.f_code.co_filename, trace.tb_lineno).strip()
        self.error, self.refusal = error, Refusal(UserError(*str(error).splitlines()).typed)
        _compared(f"> {call}", type(error).__name__, self.refusal)
        return True

    @property
    def where(self) -> str:
        """What the first line is about."""
        return self.refusal.where


def refused(kind: type[BaseException] = UserError) -> Raised:
    """``with refused() as found:`` around the call that has to raise; ``found.where`` after it."""
    return Raised(kind)


def refused_command(*arguments: object, code: int = 2) -> Refusal:
    """The lines with which a command refuses, each on stderr and behind ``hfc:``."""
    words = [str(argument) for argument in arguments]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == code, done.output
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert lines
    assert all(line.startswith("hfc: ") for line in lines), done.stderr
    _compared(f"$ hfc {' '.join(words)}", f"exit {code}", done.stderr)
    return Refusal(done.stderr)


def _compared(call: str, how: str, lines: str) -> None:
    """Keep an entry, and compare it with that of the file."""
    test = os.environ["PYTEST_CURRENT_TEST"].rpartition(" (")[0].removeprefix("tests/")
    entry = "\n".join([call, how, lines.rstrip("\n")])
    for place, name in PLACES:
        entry = place.sub(name, entry)
    SAID[test].append(entry)
    if ASKED != "compare":
        return
    known = kept().get(test, [])
    number = len(SAID[test]) - 1
    told = known[number] if number < len(known) else "nothing: make wording"
    assert entry == told, f"{FILE.name} has another line for {test}"


def kept() -> dict[str, list[str]]:
    """Of every test what the file has."""
    if not _KEPT and FILE.exists():
        for part in FILE.read_text(encoding="utf-8").split("\n== ")[1:]:
            test, _, entries = part.rstrip("\n").partition("\n")
            _KEPT[test] = entries.split("\n\n")
    return _KEPT


_KEPT: dict[str, list[str]] = {}


def write(said: dict[str, list[str]]) -> None:
    """Write the file: what was ``said`` now; of files of which no test ran, what is kept."""
    ran = {test.partition("::")[0] for test in said}
    others = {test: own for test, own in kept().items() if test.partition("::")[0] not in ran}
    head = "What users read where something is refused; `make wording` writes this file.\n"
    found = sorted((others | said).items())
    parts = [f"\n== {test}\n" + "\n\n".join(own) + "\n" for test, own in found]
    FILE.write_text(head + "".join(parts), encoding="utf-8")
