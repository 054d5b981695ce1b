"""The experiment of Lin & Gai 2009: figures that must hold, and that its page shows them."""

import pytest
from experiment_pages import page_of, ran, stands_in, table

from experiments.lin_gai_2009 import page as lg09
from hfc_design.files.loop_setup import load_design

RUN = ("corrected", "printed", "fast")


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    wanted = lambda cell: cell.settings["label"].startswith(RUN)  # noqa: E731
    return ran(tmp_path_factory.mktemp("runs") / "lg09", "lin_gai_2009/batch.toml", wanted)


def test_published_figures(batch):
    rows = [*batch.published(), *lg09.endings(batch), *lg09.read_off(batch)]
    stands_in(lg09, rows)
    falls = [float(row[3]) for row in rows if "compensated / PID" in row[1]]
    assert len(falls) == 8
    assert max(falls[:4]) <= 0.60  # Z, by at least 40 %
    assert max(falls[4:]) <= 0.85  # C, by at least 15 %
    overshoots = [row[3] for row in rows if "overshoot" in row[1]]
    assert overshoots == ["0"] * 10
    most = {row[1][0]: float(row[3]) for row in rows if "largest error, PID" in row[1]}
    for axis in "XA":  # the velocity over the gain, and what friction costs
        printed = 15.0 if axis == "X" else 10.0
        assert 0.9 * printed < most[axis] < 0.92 * printed
    shortest = {row[5]: float(row[3]) for row in rows if row[1] == "way of C [deg]"}
    # by hand, from fig. 4
    assert shortest["corrected program"] == pytest.approx(0.007 + 0.3, abs=0.002)
    assert shortest["printed program"] == pytest.approx(0.007 + 0.005 + 0.99 + 1.285, abs=0.005)


def test_most_of_it_is_gain(batch):
    for name in ("corrected", "printed"):
        pid, linear, sliding = (
            batch.values(f"{name}, {told}", "z_max_error_mm", "c_max_error_deg")
            for told in ("PID", "PID of that gain", "fuzzy sliding")
        )
        for own, same, fuzzy in zip(pid, linear, sliding, strict=True):
            assert (own - same) / (own - fuzzy) > 0.8
    for axis_table in map(lg09.each_axis, [batch] * 2, ("corrected", "printed")):
        assert axis_table in page_of(lg09)


def test_the_linear_gain_is_that_of_the_rules():
    """By hand: the command of SP over the error of SP, and k lambda / phi of the switching part."""
    inner = load_design("lin-gai-2009-fuzzy-sliding").controller.axes
    told = {row[0]: row for row in table(page_of(lg09))}
    assert "PID of that gain" in told
    for axis, expected in {"x": 0.6, "y": 0.5833, "z": 0.5833, "a": 0.9, "c": 0.8667}.items():
        own = inner[axis]
        rules = own.consequents[4][3] / (own.largest_error / 3.0)
        sliding = own.sliding.gain * own.sliding.slope / own.sliding.boundary_layer
        assert rules + sliding == pytest.approx(expected, abs=2e-4)
