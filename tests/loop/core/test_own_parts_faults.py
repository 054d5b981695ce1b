"""Own parts with a field that is missing, of the wrong type, or whose code raises: one line."""

from run_folders import hfc
from wording import refused, refused_command

from hfc_design import api
from hfc_design.core.plugins import know

SMALL = {"simulation.duration_s": 0.5, "search.population": 4, "search.generations": 1}


def test_an_error_in_its_sections_loses_no_search(own):
    (own / "kinds.py").write_text(
        "from dataclasses import replace\n"
        "from hfc_design.controllers.kinds import KINDS\n"
        "KIND = replace(KINDS.get('pd'), name='mine', sections=lambda record, shown: 1 / 0)\n"
    )
    own_parts = [("plant", "mine:SLEDGE"), ("controller", "kinds:KIND")]
    know(own_parts)
    ranges = {"kp": [1.0, 100.0], "kd": [0.1, 10.0]}
    changes = {"controller": {"kind": "mine", "ranges": ranges}}
    with refused() as found:
        api.design(api.load_scenario("sledge.toml", changes | SMALL), "run")
    assert "(the design is saved)" in found.refusal
    options = [text for what, name in own_parts for text in (f"--{what}", name)]
    assert found.refusal in refused_command("report", "run", *options)
    assert hfc("score", "run", *options).exit_code == 0
