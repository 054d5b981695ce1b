"""Whether it can be used, on the page of a run."""

import json
import re
import shutil

import pytest

from hfc_design.report.in_use import in_use
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


def test_whether_it_can_be_used(with_answer):
    text = with_answer.read_text()
    places = [text.index(part) for part in ("Can I use it?", "only 99.6 %", "<img", "<table")]
    assert places == sorted(places)  # the answer, the picture that shows it, and then tables
    part = text[text.index("On other machines") : text.index("The controller</h2>")]
    heads = re.findall(r'<th scope="col"[^>]*>(.*?)</th>', part)
    assert heads[1:3] == ["keep all [%]", "error once settled [µrad]"]
    rows = re.findall(r'<tr><th scope="row">(.*?)</tr>', part)
    cells = [re.split("<[^>]+>", row)[0::2] for row in rows]
    assert [cell[0] for cell in cells] == ["ramp *", "position"]
    assert part.count("* is asked of the nominal machine alone.") == 1
    assert "keeps everything from 0.455 to at least 16 times the command." in part
    assert cells[0][1:4] == ["100", "3.57 / 3570", "3.79 / 3790"]
    assert cells[1][1:3] == ["99.8", "7.14 / 7140"]
    named = re.findall("<dt>(.*?)</dt>", part)  # every reason that follows is explained
    assert {*named} >= {"is far off", "swings", "stays at a limit"}
    (why,) = re.findall("<li>(.*?)</li>", part)  # of those motions that some do not keep
    assert why == "position: 2 swing, 2 break unsettled, 1 is far off, 1 stays at a limit"


def test_an_error_in_metres_has_a_unit_that_needs_no_power_of_ten():
    """Of a feed drive; one unit for all motions, the chatter stays in V."""
    units = USED["units"] | {"settled_rms_error": "m"}
    motions = {name: told(1.0, {}, scale) for name, scale in (("one", 1.0), ("two", 2.0))}
    found = in_use(USED | {"units": units, "motions": motions})
    assert found["heads"][2:4] == ["error once settled [µm]", "chatter [V]"]
    assert found["rows"][0][2] == "3.57 / 3570"
    assert found["rows"][1][2] == "7.14 / 7140"


def test_an_edited_answer_is_left_out(report, with_answer, monkeypatch):
    edited = USED | {"units": {"chatter": "V"}}
    monkeypatch.setattr("hfc_design.report.page.used", lambda *_: edited)
    (scenario, result, _, rivals), _ = report
    write_page(scenario, result, with_answer.parent, rivals)
    assert "Can I use it?" not in with_answer.read_text()
