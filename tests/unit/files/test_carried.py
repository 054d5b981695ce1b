"""A design takes along the files that its scenario names: it can be used in any folder."""

import hashlib
import json

from carried_files import CUT, ON_TABLES, SOURCE, WAY
from wording import refused

from hfc_design.core.embedded_files import embedder
from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import scenario_of
from hfc_design.runs import individuals
from hfc_design.runs.individuals import design_with


def test_what_is_too_long_lies_beside_and_is_known_by_its_hash(own_tables, monkeypatch):
    room = len(json.dumps(WAY))
    monkeypatch.setattr(individuals, "embedder", lambda: embedder(room))
    scenario = scenario_of({"name": "mine"} | ON_TABLES, "mine.toml", own_tables)
    design = design_with(SOURCE, scenario)
    load = {"name": "cut.csv", "sha256": hashlib.sha256(CUT.encode()).hexdigest()}
    assert design.provenance["scenario"]["load"]["file"] == load
    (own_tables / "mine.json").write_text(design_json(design))
    found = load_design(own_tables / "mine.json")
    own = own_scenario(found, str(own_tables / "mine.json"))
    assert (own.samples().axes[0].loads == scenario.samples().axes[0].loads).all()
    (own_tables / "cut.csv").write_text(CUT.replace("1", "2"))
    with refused() as told:
        own_scenario(found, str(own_tables / "mine.json"))
    assert "load.file.name = 'cut.csv': " in told.refusal
    (own_tables / "cut.csv").unlink()
    with refused() as told:
        own_scenario(found, str(own_tables / "mine.json"))
    assert "load.file.name = 'cut.csv': " in told.refusal


def test_a_design_of_a_strategy_that_is_not_here_has_its_scenario():
    """Nothing is searched where it is scored; another preset that there is stays."""
    for preset, found in (("hunt", "race"), ("l-shade", "l-shade")):
        told = {"name": "made", "search": {"preset": preset}, "load": {"constant": 5.0}}
        design = load_design("pd-only").model_copy(update={"provenance": {"scenario": told}})
        scenario = own_scenario(design, "design.json")
        assert (scenario.search.preset, scenario.load.constant) == (found, 5.0)
