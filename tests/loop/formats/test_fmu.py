"""FMUs without a program of others: what is in them, what they refuse, what their binary does."""

import pytest

from hfc_design.core.records import UserError
from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS

AFLC = load_design("jee-koren-2004-aflc")


def test_a_name_that_every_fmu_has_is_refused(tmp_path):
    with pytest.raises(UserError, match=r"design model: an FMU has a model.c of its own"):
        FORMATS["fmu"].write(AFLC.model_copy(update={"name": "model"}), tmp_path / "a")
