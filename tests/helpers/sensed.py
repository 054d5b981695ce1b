"""The C-axis under a PD controller, with sensors and converters of all sorts."""

import hfc_design.api as hfc


def scenario(*changes):
    return hfc.load_scenario("c-axis-ramp", ["simulation.duration_s=0.5", *changes])


def moved(found, kp=758.405, kd=743.010):
    """The motion of the only axis."""
    evaluation = hfc.evaluate(hfc.with_gains(found, "pd", {"kp": kp, "kd": kd}), found)
    assert not evaluation.diverged
    return evaluation.axes[0].motion


def axes(y):
    """Motions of an X-Y machine, the Y axis of which has a converter of its own."""
    limits = {"command": 120.0, "resolution": 3.0, "axes": {"y": {"resolution": 5.0, **y}}}
    changes = {"limits": limits, "simulation.duration_s": 0.5}
    found = hfc.load_scenario("feed-drive-circle", changes)
    return [axis.motion for axis in hfc.evaluate("jee-koren-2004-pid", found).axes]
