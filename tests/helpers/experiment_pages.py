"""Published experiments: their batches run here, and the pages that show what came out."""

import re
from pathlib import Path

from experiments import shared
from hfc_design.batch import folder
from hfc_design.batch.plan import read_batch
from hfc_design.batch.runner import Place, run_cells

NUMBER = re.compile(r"-?[\d.]+(?:e[+-]\d+)?")
EXPERIMENTS = Path(shared.__file__).parent


def page_of(module):
    """The page beside the module of an experiment."""
    return (Path(module.__file__).parent / "README.md").read_text(encoding="utf-8")


def table(page):
    """The cells of each row of all tables of a page."""
    lines = (line for line in page.splitlines() if line.startswith("| "))
    return [[cell.strip() for cell in line[1:-1].split("|")] for line in lines]


def ran(out, file, wanted=lambda cell: True, changes=()):
    """The wanted cells of a batch file, run; ``changes`` are laid over all of them."""
    plan = read_batch(EXPERIMENTS / file, changes)
    cells = [cell for cell in plan.cells if wanted(cell)]
    folder.note_plan(out, plan)
    failed = []
    run_cells(out, cells, Place(), lambda cell, outcome: failed.append(outcome.reason))
    assert not any(failed)
    return shared.Batch(out)


def stands_in(module, rows):
    """The page has each row with the published figure, and to the digit where nothing learns.

    What learns may differ between machines: a last bit decides which way a half is rounded. What
    finer steps of the integration move is a range on the page, and that of other windows stands
    behind the remark.
    """
    page = table(page_of(module))
    for row in rows:
        same = [line for line in page if line[:3] == row[:3] and remark(line) == row[5]]
        assert same, row
        if not any(word in row[1] for word in ("AFLC", "SOFLC", "time")):
            assert any(within(row[3], line[3]) for line in same), row


def remark(line):
    """That of a row without what other windows make of its figure."""
    return "; ".join(part for part in line[5].split("; ") if not part.endswith(" s left out"))


def alike(row, line):
    """Whether every cell of a row is what a page shows, or in the range that it shows."""
    return len(row) == len(line) and all(map(within, row, line))


def within(figure, shown, share=0.0):
    """Whether a figure is what a page shows, or in the range that it shows, ``share`` wider."""
    ends = [float(part) for part in shown.split(" to ") if NUMBER.fullmatch(part)]
    if figure == shown or not ends or not NUMBER.fullmatch(figure) or (len(ends) < 2 and not share):
        return figure == shown
    return ends[0] * (1.0 - share) <= float(figure) <= ends[-1] * (1.0 + share)


def simulated(batch):
    """Simulated figure by what it is; the first of equal names."""
    return {row[1]: float(row[3]) for row in reversed(batch.published()) if row[3] != "–"}
