"""Pictures of a program of five axes, read back from the figures."""

from hfc_design.report import plots
from hfc_design.report.errors import errors
from hfc_design.simulation.evaluating import evaluate


def test_a_program_of_five_axes_has_both_errors_off_its_path_and_every_axis():
    found = evaluate("lin-gai-2009-pid", "five-axis-program")
    figure = plots.motion(found, "PID")
    titles = [axes.get_title(loc="right") for axes in figure.axes]
    assert titles[:2] == ["contour error [mm]", "orientation error [deg]"]
    names = [f"{axis} {what}" for axis in "xyzac" for what in ("position", "error", "voltage")]
    assert [title.partition(" [")[0] for title in titles[2:]] == names
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["axis", "reference"]
    error = figure.axes[0].lines[0].get_ydata()
    assert max(error) == found.metrics["max_contour_error_mm"]
    drawn = errors({"PID": found})
    seen = [axes for axes in drawn.axes if axes.get_visible()]
    assert [x.get_title(loc="left") for x in seen] == ["contour", "orientation", *"xyzac"]
    assert [x.get_title(loc="right") for x in seen][:3] == [
        "error [mm]",
        "error [deg]",
        "error [mm]",
    ]
    assert drawn.get_figheight() < 9.0  # a page has no more
