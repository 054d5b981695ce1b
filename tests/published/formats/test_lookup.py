"""What ``--lookup`` says of its table, beside the runtime on the vectors of the folder."""

import numpy as np
import pytest
from flash_folders import vectors

from hfc_design.files.pairing import load_design
from hfc_design.formats.c_folder import write_lookup

NAME = "lin-lee-1999-table-1"


def test_axes_with_limits_of_their_own_have_tables_of_their_own(tmp_path):
    design = load_design(
        NAME, {"plant.axes": {"a": {}, "b": {}}, "limits.axes.b": {"command": 4.0}}
    )
    found = write_lookup(design, tmp_path / "c", 33)
    assert found.keys() == {"a", "b"}
    assert found["b"].off_share == pytest.approx(found["b"].off / 4.0)
    _, _, a = vectors(tmp_path / "c" / "a")
    assert "tabulated at 33 values" in a
    assert np.abs(vectors(tmp_path / "c" / "b")[1][:, -1]).max() == 4.0
    assert np.abs(vectors(tmp_path / "c" / "a")[1][:, -1]).max() > 4.0
