"""A scenario on two tables, and a design that was made with them and lies without them."""

import shutil

import pytest

from hfc_design.files.design import design_json, named_design
from hfc_design.files.named_scenario import scenario_of
from hfc_design.runs.individuals import design_with
from hfc_design.simulation.evaluating import evaluate

WAY = "time_s,reference_rad\r\n0,0\r\n0.05,0.001\r\n0.1,0.0015\r\n"
CUT = "0,0\n0.05,1\n"
SHORT = {"simulation": {"duration_s": 0.1}}
ON_TABLES = {"reference": {"kind": "csv", "file": "way.csv"}, "load": {"file": "cut.csv"}} | SHORT
SOURCE = named_design("pd-only").controller.model_dump(mode="json")


@pytest.fixture
def own_tables(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "way.csv").write_bytes(WAY.encode())
    (tmp_path / "there" / "cut.csv").write_text(CUT)
    return tmp_path / "there"


@pytest.fixture
def carried(own_tables, tmp_path, monkeypatch):
    """A design that was made with two files, alone in another folder; where it scores what."""
    scenario = scenario_of({"name": "mine"} | ON_TABLES, "mine.toml", own_tables)
    design = design_with(SOURCE, scenario)
    fitness = evaluate(design, scenario).fitness
    shutil.rmtree(own_tables)
    here = tmp_path / "here"
    here.mkdir()
    (here / "mine.json").write_text(design_json(design))
    monkeypatch.chdir(here)
    return here / "mine.json", fitness
