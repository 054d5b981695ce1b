"""FIS read back by Octave's fuzzy-logic-toolkit: every unit, and controller.m sample by sample.

Measured, relative to the largest output: 2e-15 on all points of Table II, the AFLC and a random
design. Octave takes 24 ms a point, so the suite tries one point in 50 and 25 samples, and units of
one design of each sort. MATLAB is not free; what its fistree takes is checked by its words alone,
in tests/unit/formats/test_fuzzy_files.py.
"""

import numpy as np
import pytest
from wiring import DESIGNS, UNITS, design, random_signals, unit_error

from hfc_design.controllers.flc.record import CompensationRecord
from hfc_design.formats import FORMATS
from hfc_design.runtime import Controller

EVERY = 50
COUNT = 25
WHOLE = [*UNITS[:-1], *DESIGNS[-4:]]


@pytest.mark.parametrize("name", UNITS)
def test_every_unit_reads_back(name, octave, tmp_path):
    def evaluate(file, _row, _column, points):
        np.savetxt(tmp_path / "points", points, fmt="%.17g")
        output = tmp_path / f"{file.stem}.out"
        return octave("evaluate_fis.m", file, tmp_path / "points", output)

    record, folder = design(name), tmp_path / "out"
    FORMATS["fis"].write(record, folder)
    assert unit_error(record, folder, "fis", evaluate, every=EVERY) <= 1e-9


@pytest.mark.parametrize("name", [*WHOLE, "P", "PI", "PD"])
def test_controller_m_gives_the_commands_of_the_runtime(name, octave, tmp_path):
    record = form(name) if len(name) < 3 else design(name)
    compare(record, octave, tmp_path)


def compare(record, octave, tmp_path):
    FORMATS["fis"].write(record, tmp_path / "out")
    signals = random_signals(record, COUNT) | {
        "velocity": 400.0 * np.random.default_rng(3).uniform(-1.0, 1.0, COUNT) ** 3
    }
    np.savetxt(tmp_path / "signals", np.stack(list(signals.values()), axis=1), fmt="%.17g")
    arguments = tmp_path / "out", tmp_path / "signals", ",".join(signals), tmp_path / "commands"
    found = octave("evaluate_controller.m", *arguments)
    controller = Controller(record)
    rows = zip(*signals.values(), strict=True)
    wanted = [controller.step(dict(zip(signals, map(float, row), strict=True))) for row in rows]
    assert np.abs(found - wanted).max() <= 1e-9 * np.abs(wanted).max()


def form(name, **changes):
    """The flc in a form of JK95 eq. 1 with an integral and low-velocity compensation."""
    record = design("jee-koren-2004-flc")
    low = CompensationRecord(
        forward=(0.5, -2.0, 3.0),
        backward=(-0.4, -1.5, -2.5),
        highest_velocity_mm_s=2.0,
        breakaway=(4.0, -5.0),
        smallest_error=1.5,
        **changes,
    )
    changes = {"form": name, "integral_gain": 0.7, "low_velocity": low}
    return record.model_copy(update={"controller": record.controller.model_copy(update=changes)})
