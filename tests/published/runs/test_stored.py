"""What made a checkpoint: another version, file or own part does not go on unasked."""

import json

from own_strategies import MODULE
from sledge import hfc

from hfc_design.core import archive

SIZES = ["search.population=6", "search.generations=4", "simulation.duration_s=0.1"]


def test_another_text_of_an_own_part(own, no_baselines):
    (own / "hunt.py").write_text(MODULE)
    options = ("--strategy", "hunt:CLIMB", "--preset", "climb", "--controller", "pd")
    small = [item for change in SIZES for item in ("--set", change)]
    assert hfc("design", "c-axis-ramp", *options, *small, "--out", "run", "--quiet").exit_code == 0
    told = json.loads(str(archive.unpacked((own / "run/checkpoint.npz").read_bytes())["made_by"]))
    assert len(told["strategy 'climb'"]) == 64
    resume = ("design", "--resume", "--out", "run", "--use", "hunt:CLIMB", "--quiet")
    assert hfc(*resume).exit_code == 0
    (own / "hunt.py").write_text(MODULE.replace("0.8 *", "0.7 *"))
    refused = hfc(*resume)
    assert refused.exit_code == 1
    assert "another strategy 'climb' ('" in refused.stderr
    assert hfc(*resume, "--anyway").exit_code == 0
