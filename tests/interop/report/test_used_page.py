"""Whether it can be used, on the page of a run."""

import json
import shutil

import phone
import pytest

from hfc_design.report.page import write_page


def told(share, reasons, scale=1.0):
    values = {"settled_rms_error": 3.57e-6, "chatter": 3.79, "peak_command": 120.0}
    measures = {
        key: {"nominal": x, "median": scale * x, "q95": x, "largest": 1000 * scale * x}
        for key, x in values.items()
    }
    own = {"share": share, "reasons": reasons, "nominal": [], "asked_of": "all"}
    return own | {"measures": measures | {"limit_share": {"median": 0.0, "largest": 0.381}}}


USED = {
    "usable": False,
    "answer": "no: only 99.6 % of 1000 unseen machines within +-15 % keep everything",
    "spread": 0.15,
    "machines": 1000,
    "share": 0.996,
    "interval": [0.9898, 0.9989],
    "gain": [0.455, 16.0],
    "precision": 0.0027,
    "substeps": None,
    "units": {"settled_rms_error": "rad", "chatter": "V", "peak_command": "V"},
    "motions": {
        "ramp": told(1.0, {}) | {"asked_of": "nominal"},
        "position": told(
            0.998, {"is far off": 1, "swings": 2, "breaks unsettled": 2, "stays at a limit": 1}, 2.0
        ),
    },
}


@pytest.fixture
def with_answer(report, tmp_path, monkeypatch):
    """The page of a run with that answer."""
    (scenario, result, folder, rivals), _ = report
    monkeypatch.setattr("hfc_design.report.page.used", lambda *_: json.loads(json.dumps(USED)))
    shutil.copy(folder / "config.toml", tmp_path)
    write_page(scenario, result, tmp_path, rivals)
    return tmp_path / "report.html"


@pytest.mark.parametrize("width", [400, 800, 1100, 1300])
def test_what_others_do_is_seen_without_scrolling(with_answer, tmp_path, width):
    (window, (table, scrolled), *others) = phone.widths(with_answer, tmp_path, width)
    assert window == width
    assert table >= scrolled or width == 400
    for left, right in others:
        assert 0 <= left < right <= width
