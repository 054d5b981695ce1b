"""The folder for LinuxCNC, as far as it can be judged without LinuxCNC."""

import re

import made_up
import numpy as np
import pytest
from exported import table, texts, with_scenario
from wording import refused

from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario, scenario_of
from hfc_design.formats import linuxcnc
from hfc_design.runs.individuals import design_with

TABLE_1 = load_design("lin-lee-1999-table-1")


def files(design):
    return texts(design, "linuxcnc")


def test_controller_reads_what_its_error_is_between():
    text = files(TABLE_1)["hfc_lin_lee_1999_table_1.comp"]
    pins = re.findall(r'^pin (in \w+|out \w+) (\w+?)_?(?: = \d)? "', text, re.M)
    read = ["reference", "spindle_angle", "reference_rate", "spindle_velocity"]
    read += ["deflection", "deflection_rate"]
    wanted = [("in bit", "enable"), *(("in float", name) for name in read)]
    wanted += [("out float", "error"), ("out float", "command"), ("out bit", "fault")]
    assert pins == wanted
    assert "inputs.error = reference_ - spindle_angle_;" in text
    assert "inputs.error_rate = reference_rate_ - spindle_velocity_;" in text
    assert "inputs.deflection = deflection_;" in text


def test_reference_is_all_of_the_scenario():
    changed = with_scenario(
        TABLE_1, "c-axis-sine", "simulation.duration_s=3", "limits.command=120", "load.constant=5"
    )
    found = files(changed)
    rows = table(found["reference.txt"])
    scenario = load_scenario("c-axis-sine").reference
    time = np.arange(3000) * 0.001
    angle = scenario.amplitude * np.sin(scenario.frequency_rad_s * time)
    assert rows.shape == (3000, 3)
    assert np.allclose(rows[:, 0], angle, rtol=0, atol=1e-15)
    assert np.allclose(rows[:, 2], 5.0, rtol=0, atol=1e-14)
    assert "setp machine.limit 120.0\n" in found["loop.hal"]
    assert "halsampler -n 3000 " in found["loop.hal"]
    assert found["loop.hal"].count(" depth=3001 ") == 2  # a queue of HAL leaves one place empty
    assert "3000 samples of the scenario c-axis-sine, to its end" in found["README.md"]
    assert "takes 3 s" in found["README.md"]


def test_load_of_a_sample_is_its_mean():
    # two substeps, so five points; Simpson's rule is exact for the cube of the time
    points = np.array([0.0, 0.25, 0.5, 0.75, 1.0])[:, None] ** 3
    assert linuxcnc._mean(points) == pytest.approx([0.25], rel=1e-15)


@pytest.mark.parametrize(
    "name",
    [
        'x); system("id',
        '";\n;;\n#include "/etc/passwd"\n"""',
    ],
)
def test_name_brings_no_code_along(name):
    found = files(TABLE_1.model_copy(update={"name": name}))
    component = linuxcnc.component_name(TABLE_1.model_copy(update={"name": name}))
    assert re.fullmatch(r"hfc_\w{1,24}", component, re.ASCII)
    assert found.keys() >= {f"{component}.comp"}
    for file, text in found.items():
        assert name not in text
        own = r"\$(?!\((CC|CFLAGS|WARNINGS|LDLIBS|SOURCES|HEADERS|PROGRAMS)\)|@)"
        assert not re.search(rf'system\("|passwd"|{own if file == "Makefile" else "[$]"}', text)
    assert found[f"{component}.comp"].count("\n;;\n") == 1


def test_a_scenario_that_cannot_run_from_here_is_refused():
    missing = {"kind": "csv", "file": "not-here.csv"}
    scenario = with_scenario(TABLE_1, "c-axis-ramp").provenance["scenario"] | {"reference": missing}
    with refused():
        files(TABLE_1.model_copy(update={"provenance": {"scenario": scenario}}))


def test_the_loop_follows_a_table_that_the_design_carries(tmp_path):
    (tmp_path / "way.csv").write_text("time_s,angle_rad\n0,0\n0.1,0.002\n0.3,-0.001\n")
    settings = {"reference": {"kind": "csv", "file": "way.csv"}, "simulation": {"duration_s": 0.5}}
    scenario = scenario_of({"name": "mine", **settings}, "mine.toml", tmp_path)
    design = design_with(TABLE_1.controller.model_dump(mode="json"), scenario)
    (tmp_path / "way.csv").unlink()
    found = files(design)
    assert "500 samples of the scenario mine" in found["README.md"]
    rows = table(found["reference.txt"])
    assert rows.shape == (500, 3)
    time = 0.001 * np.arange(500)
    expected = np.interp(time, [0.0, 0.1, 0.3], [0.0, 0.002, -0.001])
    np.testing.assert_allclose(rows[:, 0], expected, atol=1e-15)
    assert rows[[50, 150, 400], 1] == pytest.approx([0.02, -0.015, 0.0])


def test_a_controller_that_feeds_the_acceleration_forward_reads_it():
    design = made_up.linear("pid+ff", 4)
    sine = with_scenario(design, "c-axis-sine")
    found = files(sine)
    text = found["hfc_made_up.comp"]
    assert 'pin in float reference_rate_ "[rad/s]";' in text
    assert 'pin in float reference_acceleration_ "[rad/s2]";' in text
    assert "inputs.reference_acceleration = reference_acceleration_;" in text
    loop = found["loop.hal"]
    assert "loadrt streamer depth=10001 cfg=ffff\n" in loop
    assert "net reference-acceleration <= streamer.0.pin.3\n" in loop
    assert "net load streamer.0.pin.2 => machine.load\n" in loop
    rows = table(found["reference.txt"])
    time = np.arange(len(rows)) * 0.001
    np.testing.assert_allclose(rows[:, 3], -0.02 * np.sin(time), atol=1e-15)


def test_machine_has_the_coefficients_of_its_parameters():
    changed = with_scenario(TABLE_1, "c-axis-ramp", "plant.parameters.spindle_inertia=6.5")
    found = files(changed)
    leakage = 0.341 - 0.225**2 / 0.306
    for name, value in {
        "current-decay": (1.12 + 1.05 * 0.341 / 0.306) / leakage,
        "torque-constant": 0.225 * 0.6 / 0.306,
        "inverse-spindle-inertia": 1 / 6.5,
        "friction-stribeck-rise": 0.5,
    }.items():
        (told,) = re.findall(rf"^setp machine\.{name} (\S+)$", found["loop.hal"], re.M)
        assert float(told) == pytest.approx(value, rel=1e-14)
    assert "and not in degrees:" in found["README.md"]


def test_long_names_stay_apart():
    names = [f"a-name-of-which-only-the-end-{end}" for end in ("differs", "is-other")]
    components = {
        linuxcnc.component_name(TABLE_1.model_copy(update={"name": name})) for name in names
    }
    assert {len(name) for name in components} == {28}
    assert len(components) == 2


def test_names_leave_room_for_the_longest_pin():
    """NAME.0.reference-acceleration has to fit into 47 characters."""
    design = made_up.linear("pid+ff", 4).model_copy(update={"name": "x" * 60})
    assert len(linuxcnc.component_name(design) + ".0.reference-acceleration") == 47
