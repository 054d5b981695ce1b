"""The MAT export, read back by SciPy; by Octave: tests/interop/test_mat.py."""

import made_up
import numpy as np
import pytest
from scipy.io import loadmat
from wording import refused

from hfc_design.files.design import builtin_designs, named_design
from hfc_design.formats import FORMATS


@pytest.fixture
def read(tmp_path):
    def written(design):
        FORMATS["mat"].write(design, tmp_path / "design.mat")
        return loadmat(tmp_path / "design.mat", simplify_cells=True)

    return written


def same(found, wanted, key=""):
    """Whether SciPy gives what stands in the design file, to the bit."""
    if wanted is None:
        infinite = {"left": -np.inf, "right": np.inf}
        return found == infinite[key] if key in infinite else np.size(found) == 0
    if isinstance(wanted, dict):
        return set(found) == set(wanted) and all(same(found[k], wanted[k], k) for k in wanted)
    if isinstance(wanted, list) and wanted and isinstance(wanted[0], dict):
        items = [found] if isinstance(found, dict) else list(found)
        return len(items) == len(wanted) and all(map(same, items, wanted))
    return np.array_equal(np.array(found), np.array(wanted))


@pytest.mark.parametrize("name", [x for x in builtin_designs() if "" in named_design(x).by_axis()])
def test_scipy_reads_the_design_file_back_bit_for_bit(name, read):
    design = named_design(name)
    found, wanted = read(design), design.model_dump(mode="json")
    assert same(found["controller"], wanted["controller"])
    assert found["design"]["name"] == name
    assert same(found["design"]["plant"]["parameters"], wanted["plant"]["parameters"])
    assert found["design"]["facts"][1].startswith(f"design {name}, sha256 ")


@pytest.mark.parametrize("seed", [3, 7])
def test_a_linear_part_and_a_scheduled_law_are_read_back_too(seed, read):
    """One of them without signals, which is a struct without fields."""
    design = made_up.scheduling(seed)
    found, wanted = read(design)["controller"], design.model_dump(mode="json")["controller"]
    bare = []
    for part in ("linear", "scheduled"):
        signals = wanted[part].pop("signals")
        bare += [] if signals else [part]
        assert same(found[part].pop("signals"), signals) or not signals
    assert bare == ["linear"] * (seed == 3)
    assert same(found, wanted)


def test_the_wiring_counts_inputs_and_then_units_from_1(read):
    found = read(named_design("lin-lee-1999-table-1"))
    # 1 error, 2 deflection, 3 its rate, 4 spindle velocity, 5 the same a sample ago; 6 unit 7, ...
    assert found["wiring"].tolist() == [[4, 5], [6, 2], [7, 1], [8, 3]]
    assert [unit["name"] for unit in found["units"]] == ["unit_7", "unit_3", "unit_1", "unit_0"]
    assert found["units"][0]["table"][0, 1] == 0.4644  # LL Table I, unit 7
    assert read(named_design("jee-koren-2004-flc"))["wiring"].tolist() == [1, 2]


def test_a_name_is_a_string_and_never_a_field(read):
    evil = "x'); system('id"
    good = named_design("lin-lee-1999-table-1")
    assert read(good.model_copy(update={"name": evil}))["design"]["name"] == evil
    plant = good.plant.model_copy(update={"parameters": {evil: 1.0}})
    with refused():
        read(good.model_copy(update={"plant": plant}))
