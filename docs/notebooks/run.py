"""Runs notebooks from the top, as a reader would: ``python run.py NOTEBOOK ...``.

Their outputs are written anew; what else they write goes with a folder that is removed, in which
they find what lies in docs.
"""

import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import nbformat
from nbclient import NotebookClient

DOCS = Path(__file__).parents[1]
#: No cell takes longer [s].
LONGEST = 300


def executed(path: Path) -> nbformat.NotebookNode:
    """The notebook with what its cells put out now.

    Raises:
        nbclient.exceptions.CellExecutionError: a cell failed.
    """
    book = nbformat.read(path, as_version=4)
    with TemporaryDirectory() as place:
        beside = Path(place) / "docs"
        shutil.copytree(DOCS, beside, ignore=shutil.ignore_patterns("site", "pictures", "*.md"))
        own = {"metadata": {"path": str(beside / "notebooks")}}
        client = NotebookClient(book, timeout=LONGEST, resources=own, kernel_name="python3")
        client.record_timing = False
        client.execute()
    book.metadata = {"kernelspec": book.metadata.kernelspec, "language_info": {"name": "python"}}
    return book


if __name__ == "__main__":
    for name in sys.argv[1:]:
        nbformat.write(executed(Path(name)), name)
