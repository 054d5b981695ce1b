"""The numpy runtime: by hand, and against the compiled loop."""

from math import exp

import pytest

from hfc_design.controllers.hierarchical.law import LIN_LEE_TERMS
from hfc_design.files.design import Design
from hfc_design.files.pairing import load_design
from hfc_design.runtime import Controller, load

SIX_INPUTS = {
    "error": 50.0,
    "deflection": 80.0,
    "deflection_rate": 20.0,
    "spindle_velocity": 20.0,
    "previous_spindle_velocity": 10.0,
    "previous_error": 40.0,
}


def design_of(kp, kd, names, units):
    """A design over ``names``; ``units`` are (column input, row input, table)."""
    return Design.model_validate(
        {
            "name": "made-up",
            "plant": {"name": "c-axis", "parameters": {}},
            "controller": {
                "kind": "pd+hierarchical-fuzzy",
                "sample_time_s": 0.001,
                "pd": {"kp": kp, "kd": kd},
                "inputs": [{"name": name, "scale": SIX_INPUTS[name]} for name in names],
                "output_scale": 10.0,
                "terms": [term._asdict() for term in LIN_LEE_TERMS],
                "units": [
                    {"id": k, "column_input": column, "row_input": row, "consequents": table}
                    for k, (column, row, table) in enumerate(units)
                ],
            },
        }
    )


AT_02 = [exp(-4 * 1.1**2), exp(-8 * 0.75**2), exp(-32 * 0.4**2), exp(-32 * 0.2**2), 1.0]
AT_02 += [exp(-8 * 0.35**2), exp(-4 * 0.7**2)]


def test_voltage_by_hand():
    """The table is 10 i + j, so the output is 10 times the mean row plus the mean column."""
    names = ("error", "previous_spindle_velocity")
    table = [[10.0 * i + j for j in range(7)] for i in range(7)]
    runtime = Controller(design_of(100.0, 7.0, names, [(*names, table)]))
    column_at_02 = sum(j * d for j, d in enumerate(AT_02)) / sum(AT_02)
    first = runtime.step({"error": 0.004, "error_rate": 0.5, "spindle_velocity": 0.02})
    assert first == pytest.approx(0.4 + 3.5 + 10 * (10 * 3 + column_at_02))  # row 3: at u = 0
    # Now the previous velocity is 0.02, u = 0.2; the error of 1 rad is clamped to u = 1.
    second = runtime.step({"error": 1.0, "error_rate": 0.0, "spindle_velocity": 0.0})
    at_1 = [exp(-4 * 1.9**2), exp(-8 * 1.55**2), exp(-32 * 1.2**2), exp(-32), exp(-32 * 0.8**2)]
    at_1 += [exp(-8 * 0.35**2), 1.0]
    column_at_1 = sum(j * d for j, d in enumerate(at_1)) / sum(at_1)
    assert second == pytest.approx(100.0 + 10 * (10 * column_at_02 + column_at_1))


def test_pd_by_hand():
    runtime = Controller(load_design("pd-only"))
    voltage = runtime.step({"error": 0.01, "error_rate": -0.02})
    assert voltage == pytest.approx(7.58405 - 14.8602)


def test_missing_signal_is_named():
    with pytest.raises(KeyError, match="spindle_velocity"):
        Controller(load_design("lin-lee-1999-table-1")).step(
            {"error": 0.0, "error_rate": 0.0, "deflection": 0.0, "deflection_rate": 0.0}
        )


def test_a_built_in_design_is_loaded_by_its_name():
    wanted = Controller(load_design("pd-only")).step({"error": 1.0, "error_rate": 2.0})
    assert load("pd-only").step({"error": 1.0, "error_rate": 2.0}) == wanted
