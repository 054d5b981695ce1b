"""Trees whose units are not in the canonical order, as people write them."""

import jax
import numpy as np
import pytest

from hfc_design.controllers.hierarchical.law import hierarchical
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.core.numbers import SCALARS
from hfc_design.files.pairing import load_design
from hfc_design.simulation.closed_loop import LANES

SIGNALS = dict(zip(("error", "deflection", "deflection_rate"), (0.011, -0.004, 0.02), strict=True))
SIGNALS |= {"error_rate": -0.03, "spindle_velocity": 0.017}


def turned(record: HierarchicalDesign) -> HierarchicalDesign:
    """The same hierarchy with columns as rows."""
    data = record.model_dump()
    for unit in data["units"]:
        unit["column_input"], unit["row_input"] = unit["row_input"], unit["column_input"]
        unit["consequents"] = np.array(unit["consequents"]).T.tolist()
    return HierarchicalDesign.model_validate(data)


def command(xp, record, gains):
    law = hierarchical(layout_of(record), record.sample_time_s)
    return law.step(xp, gains, law.initial_memory(0.0), SIGNALS)[0]


@pytest.mark.parametrize(
    ("design", "canonical"), [("lin-lee-1999-table-1", True), ("lin-lee-1999-table-2", False)]
)
def test_a_turned_hierarchy_commands_the_same(design, canonical):
    record = load_design(design).controller
    other = turned(record)
    assert layout_of(record).canonical is canonical
    assert not layout_of(other).canonical
    exact = command(SCALARS, record, record.gains())
    assert command(SCALARS, other, other.gains()) == pytest.approx(exact, rel=1e-12)
    found = jax.jit(lambda own: command(LANES, other, own))(jax.tree.map(np.asarray, other.gains()))
    assert found == pytest.approx(exact, rel=1e-12)
