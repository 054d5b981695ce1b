"""X-Y machines in the population simulator: the published figures, a search."""

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import load_scenario
from hfc_design.simulation.evaluating import evaluate

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
    return evaluate(design, own_scenario(design, design.name))


def test_flc_has_the_published_axial_error_in_every_cycle(flc):
    error = flc.axes[0].motion.error.reshape(3, 2000)  # 20 s a cycle
    rms = np.sqrt((error**2).mean(axis=1))
    assert rms == pytest.approx(3 * [16.2], abs=0.3)  # fig. 10


def test_pid_has_the_published_contour_error_under_friction():
    found = evaluate(load_design("jee-koren-2004-pid"), load_scenario(CIRCLE, SLOW))
    assert found.metrics["rms_contour_error_BLU"] == pytest.approx(3.4, rel=0.1)  # fig. 12
    assert found.metrics["max_contour_error_BLU"] == pytest.approx(15.6, rel=0.1)


def test_a_machine_that_never_moves_is_no_good():
    """It never leaves the circle either; its lag is R sin(angle)."""
    dead = load_design("jee-koren-2004-flc").model_dump()
    dead["controller"]["rules"]["centroids"] = np.zeros((7, 7)).tolist()
    dead["controller"]["low_velocity"] = None
    found = evaluate(Design.model_validate(dead), load_scenario(CIRCLE))
    assert found.metrics["rms_contour_error_BLU"] < 1e-6
    # behind = -R sin(angle): a root mean square of R / sqrt(2) over whole cycles
    assert found.fitness == pytest.approx(1 / (0.01 * 4000 / np.sqrt(2)), rel=1e-3)


def test_a_hierarchy_can_be_searched_for_a_feed_drive(tmp_path, no_baselines, known_use):
    # As in test_judge.py, so that both have the same compiled programs.
    alike = ["--set", "simulation.duration_s=3.0", "--set", "search.stick_penalty=300"]
    sizes = ["--population", "24", "--generations", "2", *alike]
    folder = tmp_path / "run"
    result = CliRunner().invoke(
        main, ["design", "feed-drive-hierarchy", *sizes, "--out", str(folder), "--quiet"]
    )
    assert result.exit_code == 0, result.output
    found = load_design(str(folder))
    assert set(found.plant.axes) == {"x", "y"}
    assert found.plant.axes["y"]["positive_start"] == 7.23
    assert evaluate(found, own_scenario(found, str(folder))).fitness == found.score["fitness"]
    page = (folder / "report.html").read_text()
    assert "unit s/BLU" in page  # of the derivative gain
    assert "V/rad" not in page
