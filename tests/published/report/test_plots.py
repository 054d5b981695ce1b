"""What the picture of a contour shows, read back from the figure."""

import numpy as np
import pytest

from hfc_design.pictures.files import image
from hfc_design.report.errors import motion_errors
from hfc_design.simulation.evaluating import evaluate


def lines_of(axes):
    return {line.get_label(): np.array(line.get_data()) for line in axes.lines}


def test_errors_beside_rivals_in_every_motion():
    """A panel each, in its own unit; curves are the largest errors in slices of the time."""
    moves = [{"name": "ramp"}, {"name": "creep", "duration_s": 0.2}, {"name": "c", "weight": 2.0}]
    scenario = {"name": "three", "simulation": {"duration_s": 0.3}, "motions": moves}
    both = {name: evaluate(name, scenario) for name in ("pd-only", "lin-lee-1999-table-1")}
    figure = motion_errors(both)
    shown = [axes for axes in figure.axes if axes.get_visible()]
    assert [axes.get_title("left") for axes in shown] == ["ramp", "creep", "c"]
    assert len(figure.axes) == 4  # the place of a fourth stays empty
    for axes, (name, one) in zip(shown, both["pd-only"].motions.items(), strict=True):
        lines, (axis,) = lines_of(axes), one.axes
        assert list(lines) == [*both]
        unit = axes.get_title("right")
        factor = {"error [mrad]": 1e3, "error [µrad]": 1e6}[unit]
        assert lines["pd-only"][1].max() == pytest.approx(factor * abs(axis.motion.error).max())
        other = both["lin-lee-1999-table-1"].motions[name].axes[0].motion.error
        assert lines["lin-lee-1999-table-1"][1].max() == pytest.approx(factor * abs(other).max())
    assert image(figure, "png").startswith(b"\x89PNG")
