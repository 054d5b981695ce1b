"""The notebooks are as they come out: run from the top they put out what is stored."""

import json
import re
import runpy

import pytest
from doc_pages import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
RUN = ROOT / "docs" / "notebooks" / "run.py"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
#: Shown numbers have four digits at most, and their last one may be another on other processors.
NEAR = {"rel": 2e-3, "abs": 6e-3}


def texts(book):
    """Of every cell whose numbers do not hang on a search, what it prints and what it is."""
    for cell in book["cells"]:
        if cell["cell_type"] == "code" and "varies" not in cell["metadata"].get("tags", []):
            outputs = [one for one in cell["outputs"] if one.get("name") != "stderr"]
            shown = (one.get("text") or one["data"]["text/plain"] for one in outputs)
            yield "".join("".join(part) for part in shown)


def stored(path):
    return json.loads(path.read_text("utf-8"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_puts_out_what_is_stored(path, monkeypatch):
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")  # older releases warn without
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    now = runpy.run_path(str(RUN))["executed"](path)
    for new, old in zip(texts(now), texts(stored(path)), strict=True):
        assert NUMBER.sub("#", new) == NUMBER.sub("#", old)
        numbers = (list(map(float, NUMBER.findall(text))) for text in (new, old))
        one, other = numbers
        assert one == pytest.approx(other, **NEAR)
