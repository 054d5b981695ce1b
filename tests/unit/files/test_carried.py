"""A design takes along the files that its scenario names: it can be used in any folder."""

import hashlib
import json

import pytest

from hfc_design.core.carried import carrier
from hfc_design.core.records import UserError
from hfc_design.files.design import design_json, named_design
from hfc_design.files.named_scenario import scenario_of
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.runs import individuals
from hfc_design.runs.individuals import design_with

WAY = "time_s,reference_rad\r\n0,0\r\n0.05,0.001\r\n0.1,0.0015\r\n"
CUT = "0,0\n0.05,1\n"
SHORT = {"simulation": {"duration_s": 0.1}}
ON_TABLES = {"reference": {"kind": "csv", "file": "way.csv"}, "load": {"file": "cut.csv"}} | SHORT
SOURCE = named_design("lin-lee-1999-table-1").controller.model_dump(mode="json")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "way.csv").write_bytes(WAY.encode())
    (tmp_path / "there" / "cut.csv").write_text(CUT)
    return tmp_path / "there"


def test_what_is_too_long_lies_beside_and_is_known_by_its_hash(folder, monkeypatch):
    room = len(json.dumps(WAY))
    monkeypatch.setattr(individuals, "carrier", lambda: carrier(room))
    scenario = scenario_of({"name": "mine"} | ON_TABLES, "mine.toml", folder)
    design = design_with(SOURCE, scenario)
    load = {"name": "cut.csv", "sha256": hashlib.sha256(CUT.encode()).hexdigest()}
    assert design.provenance["scenario"]["load"]["file"] == load
    (folder / "mine.json").write_text(design_json(design))
    found = load_design(folder / "mine.json")
    own = own_scenario(found, str(folder / "mine.json"))
    assert (own.samples().axes[0].loads == scenario.samples().axes[0].loads).all()
    (folder / "cut.csv").write_text(CUT.replace("1", "2"))
    with pytest.raises(UserError, match=r"load\.file\.name = 'cut\.csv': is not the one that this"):
        own_scenario(found, str(folder / "mine.json"))
    (folder / "cut.csv").unlink()
    with pytest.raises(UserError, match=r"load\.file\.name = 'cut\.csv': cannot be read: No"):
        own_scenario(found, str(folder / "mine.json"))
