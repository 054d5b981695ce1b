"""What the documentation says of files and measures is so."""

import re

from places import ROOT

from hfc_design.files.named_scenario import load_scenario
from hfc_design.objectives.metrics import METRICS, RUNNING
from hfc_design.objectives.traded import NAMES
from plants import C_AXIS

DOCS = ROOT / "docs"


def test_the_file_of_ones_own_works_as_it_stands(tmp_path):
    text = (DOCS / "robustness.md").read_text()
    block, margins = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    (tmp_path / "margins.toml").write_text(margins)
    assert load_scenario(str(tmp_path / "margins.toml")).margins["gain_margin"] == 2.0
    (tmp_path / "spindle.toml").write_text(block)
    scenario = load_scenario(str(tmp_path / "spindle.toml"))
    assert scenario.search.preset == "cma"
    assert [motion.name for motion in scenario.each_motion()] == ["spindle.ramp", "spindle.slow"]
    assert scenario.robust.final == 512


def test_every_metric_is_defined_with_its_unit():
    """Those of a scenario, then the others, in units of a C-axis (contour errors: a feed drive)."""
    text = (DOCS / "trade-off.md").read_text()
    named, others = (
        {
            name: unit
            for names, unit in re.findall(r"^\| (`[^|]*) \| ([^|]*) \|", part, re.MULTILINE)
            for name in re.findall("`(.*?)`", names)
        }
        for part in text[text.index("## Metrics") : text.index("## Search")].split("More metrics")
    )
    assert named.keys() == set(NAMES) - {"tracking", "effort", "units"}
    assert others.keys() == {one.name for one in METRICS} - RUNNING.keys()
    for name, one in RUNNING.items():
        words = [C_AXIS.units.get(word, word) for word in one.unit.split(" ")]
        assert named[name] == ("BLU" if one.path else " ".join(words)), name
    assert named["band_time"] == "s"
