"""Which curves of motions are drawn, in which units."""

from types import SimpleNamespace

import numpy as np

from hfc_design.report.panels import path_panels


def off_path(error):
    """An evaluation of a machine of any axes, as far as it is off its path [mm]."""
    error = np.array(error)
    path = SimpleNamespace(any_axes=True, unit="mm", error=error, turned=None)
    return SimpleNamespace(contour=path, axes=(), diverged=False, time=error)


def test_errors_off_a_path_of_several_designs_have_one_unit():
    """0.02 mm alone is read in µm, beside 2 mm in mm."""
    fine, rough = off_path([0.0, 0.02]), off_path([0.5, 2.0])
    (alone,) = path_panels({"fine": fine})
    assert (alone.label, alone.curves["fine"][1]) == ("contour error [µm]", 20.0)
    (panel,) = path_panels({"fine": fine, "rough": rough})
    assert panel.label == "contour error [mm]"
    assert [curve[1] for curve in panel.curves.values()] == [0.02, 2.0]
