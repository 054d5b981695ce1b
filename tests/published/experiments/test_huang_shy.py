"""The experiment of Huang & Shy: order and size of the printed peaks, what taught the network."""

import numpy as np
import pytest
from experiment_pages import page_of, ran, remark, table, within

import hfc_design.api as hfc
from experiments.huang_shy import page as huang
from experiments.huang_shy import pictures, tables
from hfc_design.files.loop_setup import load_design
from plants.milling_table import MillingTableParameters, coefficients

ORDER = ("PID", "cross-coupling", "SOC", "neural")


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    """All runs but the laps."""
    out = tmp_path_factory.mktemp("runs") / "huang"
    return ran(
        out, "huang_shy/batch.toml", lambda cell: not cell.settings["label"].startswith("laps")
    )


def test_peaks_are_in_the_printed_order_and_within_a_factor_of_two(batch):
    peaks = np.array([batch.values(label, *tables.PEAKS) for label in ORDER])
    printed = np.array([[0.03, 0.15], [0.025, 0.075], [0.015, 0.04], [0.01, 0.02]])
    assert (np.diff(peaks, axis=0) < 0).all()
    assert peaks[0] == pytest.approx(printed[0], rel=0.2)
    assert peaks[1] == pytest.approx(printed[1], rel=0.1)
    for (_, _, name, key), wanted in zip(tables.DRAWN[2:4], printed[2:], strict=True):
        # What learns is chaotic: the impulse of the network is 0.039 to 0.041 from draw to draw.
        middle = np.median(tables.drawn(name, tables.SCENARIOS["60"], key, 5), axis=0)
        assert np.abs(np.log(middle / wanted)).max() < np.log(2.0)
    small = [batch.values(f"25 mm, {label} goes on", *tables.PEAKS) for label in ("SOC", "neural")]
    assert np.abs(np.log(np.array(small) / [[0.01, 0.03], [0.007, 0.02]])).max() < np.log(2.0)
    assert small[1][0] < small[0][0]


def test_the_page_has_what_comes_out(batch):
    """Every row; what is simulated within a fifth, as the loops are chaotic."""
    shown = table(page_of(huang))
    calculated = [*tables.axes(batch), *tables.learning(batch)]
    for row in [*batch.published(), *calculated]:
        same = [line for line in shown if line[:3] == row[:3] and remark(line) == row[5]]
        assert same, row
        assert within(row[3], same[0][3], share=0.3), row
    for name, draw in huang.PARTS.items():
        if name != "laps":
            assert draw(batch).axes
    assert len(calculated) == 11
    assert pictures.circle(batch).axes[0].get_ylabel().strip() == pictures.ERROR


def test_feed_forward_is_the_viscous_friction_of_the_plant():
    fixed = coefficients(MillingTableParameters())
    friction = fixed.axis.driving_damping + fixed.axis.viscous
    for gain in load_design("huang-cross-coupled").controller.feed_forward.values():
        assert gain == pytest.approx(friction / fixed.force_gain, rel=0.02)
    inner = load_design("huang-cross-coupled").controller.inner
    assert inner.pid == load_design("huang-pid").controller.pid


@pytest.mark.parametrize("label", ["soc", "neural"])
def test_what_goes_on_is_the_design_but_for_what_it_has_learnt(label):
    file = tables.HERE / f"{label}-lap-1.json"
    whole, found = load_design(f"huang-{label}"), load_design(str(file))
    learnt = {"soc": "table", "neural": "weights"}[label]
    for axis in found.controller.axes.values():
        assert axis.model_dump(exclude={learnt}) == whole.controller.model_dump(exclude={learnt})
        assert getattr(axis, learnt) != getattr(whole.controller, learnt)
    assert found.provenance["learned"]["scenario"] == "milling-table-circle"


def test_the_network_is_what_back_propagation_makes_of_the_lap():
    """Eight passes in matrices, from weights between -1 and 1: the same command for an error."""
    record = load_design("huang-neural").controller
    lap = hfc.evaluate("huang-soc", "milling-table-circle")
    error = np.stack([axis.sensed()["error"] for axis in lap.axes], axis=1)
    wanted = np.stack([axis.motion.command for axis in lap.axes], axis=1).ravel() / 300.0
    change = np.diff(error, axis=0, prepend=error[:1])
    inputs = np.stack([error.ravel(), change.ravel(), np.full(error.size, 0.002)], axis=1) / 0.002
    random = np.random.default_rng(0)
    hidden, output = random.uniform(-1.0, 1.0, (25, 3)), random.uniform(-1.0, 1.0, 26)
    moved, shifted = 0.0 * hidden, 0.0 * output
    for row, target in zip(np.tile(inputs, (8, 1)), np.tile(wanted, 8), strict=True):
        active = np.append(np.tanh(1e-3 * (hidden @ row)), 1.0)
        step = 0.5 * (target - output @ active)
        back = 1e-3 * step * output[:-1] * (1.0 - active[:-1] ** 2)
        moved = np.outer(back, row) + 0.005 * moved
        shifted = step * active + 0.005 * shifted
        hidden, output = hidden + moved, output + shifted
    own = np.array(record.weights.hidden), np.array(record.weights.output)
    # In V/mm and V s/mm of a small error and its change; the record differs between machines.
    gains = [0.3 * (w[:-1] @ h[:, :2]) / 0.002 for h, w in ((hidden, output), own)]
    assert gains[1] == pytest.approx(gains[0], rel=0.05)
    assert gains[1] == pytest.approx([95.0, 240.0], rel=0.1)
