"""Curves for a page keep every extreme; ball bars show radii, contours what lies across a path."""

import numpy as np

from hfc_design.report.comparison.traces import panels
from hfc_design.simulation.comparing import compare


def test_a_diverged_motion_does_not_hide_the_others():
    found = compare(
        {"a": "pd-only", "b": ("pd-only")}, {"simulation": {"duration_s": 0.2}}, machines=1
    )
    bout = found.bouts[0]
    one = bout.found["b"].motion
    (axis,) = one.axes
    error = axis.motion.error.copy()
    error[50:] = 10.0 ** np.arange(150)
    gone = axis._replace(motion=axis.motion._replace(error=error))
    lost = bout.found["b"]._replace(motion=one._replace(axes=(gone,), diverged=True))
    shown = panels(bout._replace(found=bout.found | {"b": lost}))
    assert shown[0].label == "error [µrad]" or shown[0].label == "error [mrad]"
    assert np.isfinite(shown[0].curves["a"]).all()
    assert np.isnan(shown[0].curves["b"][60:]).all()
