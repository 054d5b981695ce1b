"""LinuxCNC's own pid, with the exported lines, moves a machine as the simulator does."""

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
    *("sensors.difference_samples=1", "sensors.encoder_resolution=0"),
    "plant.parameters.encoder_resolution=5e-5",
]
TABLE = "milling-table-circle", "simulation.duration_s=8"
AHEAD = {"velocity": 0.006, "acceleration": 0.0027, "coulomb": 0.5, "coulomb_width": 2.0}
AHEAD |= {"load": 0.001, "expected_load": 50.0}
#: HAL's text has six decimals.
TEXT = 5.001e-7


def pid_ff(name, *changes):
    scenario = load_scenario(name, [*changes, "controller={kind='pid+ff'}"])
    gains = {"kp": 39.0, "ki": 400.0, "kd": 0.24, "feed_forward": AHEAD}
    return with_gains(scenario, "pid+ff", gains)


@pytest.mark.parametrize(
    "made",
    [
        lambda: pid_ff("positioning-stage-move", *STAGE),
        lambda: pid_ff(*TABLE),  # two axes with backlash; a tachometer
        lambda: with_scenario(named_design("huang-pid"), *TABLE),
    ],
    ids=["stage", "table", "pid"],
)
def test_the_error_is_that_of_the_simulator(hal, made, tmp_path):
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
        assert abs(error - wanted).max() <= 1e-5 * abs(wanted).max() + TEXT
