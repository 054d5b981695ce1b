"""X-Y machines in the population simulator: the published figures, contour fitness, bad input."""

import numpy as np
import pytest

from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design, own_scenario
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.score_tables import notes

CIRCLE = "feed-drive-circle"
#: Jee & Koren 2004, fig. 12: the lower feed, with the Coulomb friction that spec and plant settle.
SLOW = [
    "reference.radius_mm=20.0",
    "reference.feed_mm_min=377.0",
    "plant.parameters.gain=28.3",
    "plant.parameters.coulomb=15.0",
]


@pytest.fixture(scope="module")
def flc():
    design = load_design("jee-koren-2004-flc")
    return evaluate(design, own_scenario(design, "jee-koren-2004-flc"))


def test_flc_has_the_published_axial_error_in_every_cycle(flc):
    error = flc.axes[0].motion.error.reshape(3, 2000)  # 20 s a cycle
    rms = np.sqrt((error**2).mean(axis=1))
    assert rms == pytest.approx(3 * [16.2], abs=0.3)  # fig. 10


def test_pid_has_the_published_contour_error_under_friction():
    found = evaluate(load_design("jee-koren-2004-pid"), load_scenario(CIRCLE, SLOW))
    assert found.metrics["rms_contour_error_BLU"] == pytest.approx(3.4, rel=0.1)  # fig. 12
    assert found.metrics["max_contour_error_BLU"] == pytest.approx(15.6, rel=0.1)


def test_contour_metrics_and_fitness_are_those_of_the_radius(flc):
    x, y = (axis.motion.state.position for axis in flc.axes)
    radius = np.hypot(x + 4000.0, y)  # the circle starts at (R, 0)
    rms, worst = np.sqrt(((radius - 4000.0) ** 2).mean()), abs(radius - 4000.0).max()
    assert flc.metrics["rms_contour_error_BLU"] == pytest.approx(rms, rel=1e-9)
    assert flc.metrics["max_contour_error_BLU"] == pytest.approx(worst, rel=1e-9)
    # The lag: how far the machine is behind in the direction in which the circle goes on.
    angle = 754 / 60 / 40 * flc.time
    away = np.stack([x + 4000.0, y]) - 4000.0 * np.stack([np.cos(angle), np.sin(angle)])
    lag = (away * np.stack([-np.sin(angle), np.cos(angle)])).sum(axis=0)
    whole = rms + 0.3 * worst + 0.01 * np.sqrt((lag**2).mean())
    assert flc.fitness == pytest.approx(1 / whole, rel=1e-6)


def test_a_machine_that_never_moves_is_no_good():
    """It never leaves the circle either; its lag is R sin(angle)."""
    dead = load_design("jee-koren-2004-flc").model_dump()
    dead["controller"]["rules"]["centroids"] = np.zeros((7, 7)).tolist()
    dead["controller"]["low_velocity"] = None
    found = evaluate(Design.model_validate(dead), load_scenario(CIRCLE))
    assert found.metrics["rms_contour_error_BLU"] < 1e-6
    # behind = -R sin(angle): a root mean square of R / sqrt(2) over whole cycles
    assert found.fitness == pytest.approx(1 / (0.01 * 4000 / np.sqrt(2)), rel=1e-3)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["reference.feed_mm_min=99999.0"], ["feed of 99999 mm/min", "largest feed"]),
        (["reference={kind='ramp'}"], ["reference.kind = 'ramp'", "2 axes", "X-Y"]),
        (["plant.axes={}"], ["reference.kind = 'circle'", "one axis of feed-drive"]),
        (["plant.axes.x.gain=-1.0"], ["plant.axes.x", "gain = -1.0", "more than zero"]),
        (["fitness.kind='best'"], ["fitness", "'best'", " contour,"]),
    ],
)
def test_machines_that_cannot_follow_are_refused(changes, words):
    with pytest.raises(UserError) as refusal:
        load_scenario(CIRCLE, changes)
    for word in [CIRCLE, *words]:
        assert word in str(refusal.value)


def test_a_path_that_the_simulation_cuts_short_is_told():
    """60 s of a circle: said of 10 s, not of all of it."""
    whole, part = (load_scenario(CIRCLE, {"simulation.duration_s": x}) for x in (60.0, 10.0))
    assert notes(whole, {}) == []
    assert "ends after 10 s of a path of 60 s" in notes(part, {})[0]
