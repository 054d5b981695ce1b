"""The one import of scripts: names are taken wherever records are, and refused in one line."""

import numpy as np
import pytest

import hfc_design.api as hfc

SHORT = {"simulation.duration_s": 0.1}
FOUND = hfc.load_design("pd-only")
RAMP = hfc.load_scenario("c-axis-ramp", SHORT)


@pytest.fixture
def short(tmp_path):
    """A scenario as what would stand in a file, as a file, and as its path in a text."""
    told = {"name": "short", "simulation": {"duration_s": 0.1}}
    (tmp_path / "short.toml").write_text("[simulation]\nduration_s = 0.1\n")
    return told, tmp_path / "short.toml", str(tmp_path / "short.toml")


def test_a_design_and_a_scenario_by_what_names_them(short, tmp_path):
    wanted = hfc.evaluate(FOUND, RAMP)
    (tmp_path / "run").mkdir()
    file = hfc.export("pd-only", "json", tmp_path / "run" / "design.json")
    for design in ("pd-only", file, str(file), file.parent, FOUND):
        for scenario in (*short, RAMP):
            assert hfc.evaluate(design, scenario).fitness == wanted.fitness


def test_everything_that_takes_a_record_takes_a_name(short, tmp_path):
    told, *_ = short
    assert hfc.with_gains(told, "pd", {"kp": 2000.0, "kd": 500.0}).controller.pd.kp == 2000.0
    assert hfc.with_gains("c-axis-ramp", "pd", {"kp": 1.0, "kd": 2.0}).plant.name == "c-axis"
    by_name = hfc.robustness("pd-only", told, 0.1, 4)
    np.testing.assert_array_equal(
        by_name.values["fitness"], hfc.robustness(FOUND, RAMP, 0.1, 4).values["fitness"]
    )
    signals = {"error": 1e-4, "error_rate": 2e-3}
    assert hfc.Controller("pd-only").step(signals) == hfc.Controller(FOUND).step(signals)
    small = {"controller": {"kind": "pd"}, "search": {"population": 4, "generations": 1}}
    assert hfc.design(told | small).design.controller.kind == "pd"
    assert hfc.load_design(FOUND) is FOUND
    assert hfc.load_scenario(RAMP) is RAMP
    assert hfc.load_design(FOUND, {"controller.pd.kp": 900.0}).controller.pd.kp == 900.0
    assert hfc.load_scenario(RAMP, {"run.seed": 3}) == RAMP.model_copy(
        update={"run": RAMP.run.model_copy(update={"seed": 3})}
    )


def test_one_alone_is_judged_as_one_of_many(short):
    told, *_ = short
    many = hfc.evaluate_many(["pd-only"], [told], [{"stiffness": 150.0}])
    assert many.merit.shape == (1, 1, 1)
    alone = hfc.evaluate_many("pd-only", told, {"stiffness": 150.0})
    of_records = hfc.evaluate_many(FOUND, RAMP, {"stiffness": 150.0})
    assert alone.merit == many.merit == of_records.merit
    assert hfc.evaluate_many(FOUND, (RAMP, told)).merit.shape == (1, 2, 1)
