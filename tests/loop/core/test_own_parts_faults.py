"""Own parts with a field that is missing, of the wrong type, or whose code raises: one line."""

from sledge import BUDGET, hfc, refused


def test_an_error_in_its_sections_loses_no_search(own):
    (own / "kinds.py").write_text(
        "from dataclasses import replace\n"
        "from hfc_design.controllers.kinds import KINDS\n"
        "KIND = replace(KINDS.get('pd'), name='mine', sections=lambda record, shown: 1 / 0)\n"
    )
    options = ("--plant", "mine:SLEDGE", "--controller", "kinds:KIND")
    ranges = "controller.ranges={kp=[1.0,100.0],kd=[0.1,10.0]}"
    line = refused("design", "sledge.toml", *options, "--set", ranges, "--out", "run", *BUDGET)
    told = "controller 'mine', sections of the report (the design is saved): ZeroDivisionError"
    assert told in line
    assert told in refused("report", "run", *options)
    assert hfc("score", "run", *options).exit_code == 0
