"""The notebooks are as they come out: run from the top they put out what is stored."""

import re
import runpy

import pytest
from doc_pages import NOTEBOOKS, ROOT, stored, texts

RUN = ROOT / "docs" / "notebooks" / "run.py"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
#: Shown numbers have four digits at most, and their last one may be another on other processors.
NEAR = {"rel": 2e-3, "abs": 6e-3}


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
