"""The numpy runtime: by hand, and without JAX."""

import json
import subprocess
import sys
from math import exp

import pytest
from by_name import SIGNALS, design_of, explanation, random_design

from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.runtime import Controller, load

KIND = """
from typing import NamedTuple

from hfc_design.controllers.gains import Law


class Gains(NamedTuple):
    kp: object


LAW = Law(
    "only-kp",
    Gains((0.1, 10.0)),
    lambda zero: (),
    lambda every, gains, memory, signals: (gains.kp * signals["error"], memory),
)
"""
SCRIPT = """
import sys
from hfc_design import runtime
from hfc_design.core.records import UserError
try:
    runtime.load("own.json")
except UserError as error:
    assert "or runtime.use" in str(error), error
runtime.use("mykind:LAW")
own = runtime.load("own.json").step({"error": 2.0})
print(own, [name for name in sys.modules if name[:3] == "jax"])
"""
AT_02 = [exp(-4 * 1.1**2), exp(-8 * 0.75**2), exp(-32 * 0.4**2), exp(-32 * 0.2**2), 1.0]
AT_02 += [exp(-8 * 0.35**2), exp(-4 * 0.7**2)]
AT_1 = [exp(-4 * 1.9**2), exp(-8 * 1.55**2), exp(-32 * 1.2**2), exp(-32), exp(-32 * 0.8**2)]
AT_1 += [exp(-8 * 0.35**2), 1.0]
TABLE = [[10.0 * i + j for j in range(7)] for i in range(7)]


def test_voltage_by_hand():
    """The table is 10 i + j, so the output is 10 times the mean row plus the mean column."""
    names = ("error", "previous_spindle_velocity")
    runtime = Controller(design_of(100.0, 7.0, names, [(*names, TABLE)]))
    column_at_02 = sum(j * d for j, d in enumerate(AT_02)) / sum(AT_02)
    first = runtime.step({"error": 0.004, "error_rate": 0.5, "spindle_velocity": 0.02})
    assert first == pytest.approx(
        0.4 + 3.5 + 10 * (10 + 1) * column_at_02
    )  # as if before it stood so
    # Now the previous velocity is 0.02, u = 0.2; the error of 1 rad is clamped to u = 1.
    second = runtime.step({"error": 1.0, "error_rate": 0.0, "spindle_velocity": 0.0})
    column_at_1 = sum(j * d for j, d in enumerate(AT_1)) / sum(AT_1)
    assert second == pytest.approx(100.0 + 10 * (10 * column_at_02 + column_at_1))


def test_a_missing_signal_is_named():
    names = ("error", "error_rate", "deflection", "deflection_rate")
    with pytest.raises(KeyError, match="spindle_velocity"):
        Controller(load_design("lin-lee-1999-table-1")).step(dict.fromkeys(names, 0.0))


def test_a_built_in_design_is_loaded_by_its_name():
    wanted = Controller(load_design("pd-only")).step({"error": 1.0, "error_rate": 2.0})
    assert load("pd-only").step({"error": 1.0, "error_rate": 2.0}) == wanted


def test_reset_forgets_the_past(random_population):
    design = random_design(5, 1, random_population)
    first = dict.fromkeys(SIGNALS, 0.05)
    runtime = Controller(design)
    runtime.step(dict.fromkeys(SIGNALS, -0.02))
    remembering = runtime.step(first)
    runtime.reset()
    assert runtime.step(first) == Controller(design).step(first) != remembering


def test_an_own_kind_is_made_known_without_jax(tmp_path):
    """What the runtime advises where a kind is unknown works, in a script of its own."""
    (tmp_path / "mykind.py").write_text(KIND)
    data = {"name": "own", "plant": {"name": "sledge", "parameters": {}}}
    data["controller"] = {"kind": "only-kp", "sample_time_s": 0.001, "gains": {"kp": 3.0}}
    (tmp_path / "own.json").write_text(json.dumps(data))
    script = [sys.executable, "-c", SCRIPT]
    done = subprocess.run(script, check=True, capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout == "6.0 []\n"


def test_a_unit_of_a_hierarchy_by_hand():
    """Consequents 10 i + j: the output is 10 times the mean row plus the mean column."""
    names = ("error", "previous_spindle_velocity")
    design = design_of(100.0, 7.0, names, [(*names, TABLE)])
    found = explanation(
        design, ["error=0.004,error_rate=0.5,spindle_velocity=9,previous_spindle_velocity=0.7"]
    )
    # error: u = 0.2; velocity: 7 clamped to 1 (LL eq. 3).
    column, row = (sum(k * d for k, d in enumerate(at)) / sum(at) for at in (AT_02, AT_1))
    (unit,) = found["units"]
    assert list(unit["column"]["degrees"].values()) == pytest.approx(AT_02)
    assert list(unit["row"]["degrees"].values()) == pytest.approx(AT_1)
    assert unit["output"] == pytest.approx(10 * row + column)
    assert [(item["scaled"], item["reading"]) for item in found["inputs"]] == [
        (pytest.approx(0.2), 0.004),
        (pytest.approx(7.0), 0.7),
    ]
    best = unit["rules"][0]
    assert (best["row"], best["column"], best["consequent"]) == ("f7", "f5", 64.0)
    assert best["share"] == pytest.approx(1 / (sum(AT_02) * sum(AT_1)))
    assert sum(rule["share"] for rule in unit["rules"]) == pytest.approx(1.0)
    assert found["parts"] == pytest.approx(
        {"proportional": 0.4, "derivative": 3.5, "fuzzy": 10 * (10 * row + column)}
    )


def test_the_parts_of_a_linear_controller_by_hand():
    own = {"kind": "pid+ff", "sample_time_s": 0.01, "kp": 2.0, "ki": 50.0, "kd": 0.1}
    own["signals"] = {"deflection": -30.0}
    own["feed_forward"] = {"velocity": 10.0, "coulomb": 5.0, "coulomb_width": 0.02}
    plant = {"name": "c-axis", "parameters": {}}
    design = Design.model_validate({"name": "mine", "plant": plant, "controller": own})
    sample = "error=1,error_rate=4,deflection=0.2,reference_rate=0.01,reference_acceleration=3"
    found = explanation(design, [sample, sample])
    assert found["parts"] == pytest.approx(
        {
            "proportional": 2.0,
            "integral": 0.5,  # of the first sample
            "derivative": 0.4,
            "deflection": -6.0,
            "feed-forward of velocity": 0.1,
            "feed-forward of acceleration": 0.0,
            "feed-forward of coulomb": 2.5,
            "feed-forward of load": 0.0,
        }
    )
    assert found["command"] == pytest.approx(-0.5)
    assert found["units_of_signals"]["reference_acceleration"] == "rad/s2"
