"""Pictures of terms: their tops, their inputs, names that stay apart."""

import numpy as np
import pytest

from hfc_design.files.loop_setup import load_design
from hfc_design.report.designs import picture

DESIGNS = {
    "jee-koren-2004-flc": ("", ["error [BLU]", "change of error [BLU per sample]"]),
    "lin-gai-2009-fuzzy-sliding": ("x", ["error [mm]", "error rate [mm/s]"]),
    "lin-lee-1999-table-1": ("", ["input of a unit, scaled [1]"]),
    "huang-soc": ("", ["error, a set is 0.1 mm; its change in a sample, a set is 0.0333 mm"]),
}


@pytest.mark.parametrize(("name", "axis", "labels"), [(k, *v) for k, v in DESIGNS.items()])
def test_each_term_of_each_input_is_drawn_up_to_1(name, axis, labels):
    figure = picture(load_design(name), "terms", axis=axis)
    assert [axes.get_xlabel() for axes in figure.axes] == labels
    for axes in figure.axes:
        tops = [np.max(line.get_ydata()) for line in axes.lines]
        assert tops == pytest.approx([1.0] * len(axes.texts), abs=1e-12)
