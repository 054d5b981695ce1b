"""Plots and diagrams of a run, also of one that diverged."""

import numpy as np
from random_runs import diverged

from hfc_design.pictures.files import image
from hfc_design.report import plots
from hfc_design.report.errors import errors


def changed(evaluation, **axis):
    """The evaluation with parts of its only axis replaced."""
    return evaluation._replace(axes=(evaluation.axes[0]._replace(**axis),))


def moving(evaluation, values):
    """The motion of its only axis with these values (steps,) for everything."""
    motion = evaluation.axes[0].motion
    state = type(motion.state)(*[values] * len(motion.state))
    return motion._replace(error=values, command=values, state=state)


def nothing_but_nan(evaluation):
    nan = np.full(len(evaluation.time), np.nan)
    lost = changed(evaluation, motion=moving(evaluation, nan))
    return lost._replace(diverged=True)


def test_plots_of_a_diverged_evaluation(report):
    scenario = report[0][0]
    for evaluation in (diverged(scenario), nothing_but_nan(diverged(scenario))):
        drawing = image(plots.response(evaluation, "lost"), "svg").decode()
        assert "lost (diverged at" in drawing
        assert image(errors({"lost": evaluation}), "png")
