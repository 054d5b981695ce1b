"""LinuxCNC's own pid, with the exported lines, moves the simulated machine as the simulator does."""

import numpy as np
import pytest
from exported import with_scenario
from hal_session import exported

from hfc_design.calls.searching import with_gains
from hfc_design.files.design import named_design
from hfc_design.files.loop_setup import own_scenario
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import FORMATS
from hfc_design.simulation.evaluating import evaluate

#: A stage whose law differences its encoder over one sample; steps of the encoder are the plant's.
STAGE = [
    "reference={kind='sine',amplitude=20.0,frequency_rad_s=6.0}",
    *("sensors.difference_samples=1", "sensors.encoder_resolution=0"),
    *("plant.parameters.encoder_resolution=5e-5", "fitness.settled_after_s=1.0"),
]
AHEAD = {"velocity": 0.006, "coulomb": 0.5, "coulomb_width": 2.0, "load": 0.001}
#: HAL's text has six decimals.
TEXT = 5.001e-7
TABLE = "milling-table-circle", "simulation.duration_s=8"


def pid_ff(name, *changes, **forward):
    scenario = load_scenario(name, [*changes, "controller={kind='pid+ff'}"])
    ahead = AHEAD | {"expected_load": 50.0} | forward
    gains = {"kp": 39.0, "ki": 400.0, "kd": 0.24, "feed_forward": ahead}
    return with_gains(scenario, "pid+ff", gains)


@pytest.mark.parametrize(
    ("made", "off"),
    [
        # the second difference of the reference is behind its acceleration
        (lambda: pid_ff("positioning-stage-move", *STAGE, acceleration=0.002), 0.02),
        (lambda: pid_ff(*TABLE), 1e-5),  # two axes with backlash; a tachometer
        (lambda: with_scenario(named_design("huang-pid"), TABLE[0], TABLE[1]), 1e-5),
    ],
    ids=["stage", "table", "pid"],
)
def test_the_error_is_that_of_the_simulator(hal, made, off, tmp_path):
    """pid.hal takes the place of the exported component in its loop."""
    design = made()
    folder = exported(hal, design, tmp_path / "out")
    FORMATS["linuxcnc-pid"].write(design, folder)
    loop = (folder / "loop.hal").read_text()
    (folder / "loop.hal").write_text(loop.replace("source controller.hal", "source pid.hal"))
    hal.call("halrun", "-i", "joints.ini", "loop.hal", cwd=folder)
    rows = np.loadtxt(folder / "motion.txt").T
    axes = evaluate(design, own_scenario(design, design.name)).axes
    for error, axis in zip(rows[::3], axes, strict=True):
        wanted = axis.sensed()["error"]
        for part in (slice(None), slice(1000, None)):  # from the jump at the start, and later
            most = off * abs(wanted)[part].max() + TEXT
            assert abs(error - wanted)[part].max() <= most
