"""Pictures of several motions, read back from the figures."""

import pytest
from read_figures import lines_of

from hfc_design.files.loop_setup import load_design
from hfc_design.pictures.files import image
from hfc_design.report.errors import motion_errors
from hfc_design.simulation.evaluating import evaluate


def test_errors_beside_rivals_in_every_motion():
    """A panel each, in its own unit; curves are the largest errors in slices of the time."""
    moves = [{"name": "ramp"}, {"name": "creep", "duration_s": 0.2}, {"name": "c", "weight": 2.0}]
    scenario = {"name": "three", "simulation": {"duration_s": 0.3}, "motions": moves}
    softer = load_design("pd-only", ["controller.pd.kp=1000"])
    both = {"pd-only": evaluate("pd-only", scenario), "softer": evaluate(softer, scenario)}
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
        other = both["softer"].motions[name].axes[0].motion.error
        assert lines["softer"][1].max() == pytest.approx(factor * abs(other).max())
    assert image(figure, "png").startswith(b"\x89PNG")
