"""The notebooks are as they come out: run from the top they put out what is stored."""

from pathlib import Path

import pytest
from doc_pages import NOTEBOOKS, stored, texts


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_cell_was_run_in_order_and_is_small(path):
    code = [cell for cell in stored(path)["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in code] == [*range(1, len(code) + 1)]
    kinds = {one["output_type"] for cell in code for one in cell["outputs"]}
    assert kinds == {"stream", "execute_result"}
    streams = {one.get("name") for cell in code for one in cell["outputs"]}
    assert "stderr" not in streams
    text = path.read_text("utf-8")
    assert len(text) < 190_000
    assert str(Path.home()) not in text


def test_what_varies_is_seldom():
    """Else nothing would be compared."""
    for path in NOTEBOOKS:
        assert sum(map(len, texts(stored(path)))) > 150, path
