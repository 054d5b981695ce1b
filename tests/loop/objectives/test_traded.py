"""What the names of objectives mean in a scenario."""

from hfc_design.files.named_scenario import load_scenario

SEARCH = "search={{preset='nsga-ii', objectives={}}}"


def told(scenario, *names, changes=()):
    found = load_scenario(scenario, [SEARCH.format([*names]), *changes])
    return [(one.name, one.unit, one.measure and one.measure.name) for one in found.traded]


def test_tracking_is_what_the_scenario_tolerates_of_an_error():
    assert told("c-axis-ramp", "tracking", "effort") == [
        ("tracking", "rad", "rms_error"),
        ("effort", "V", "rms_command"),
    ]
    assert told("c-axis-practical", "chatter", "tracking") == [
        ("chatter", "V", "chatter"),
        ("tracking", "rad", "settled_rms_error"),
    ]
    assert told("feed-drive-circle", "tracking", "effort", "iae") == [
        ("tracking", "BLU", "rms_contour_error"),
        ("effort", "unit", "rms_command"),
        ("iae", "BLU s", "iae"),
    ]
