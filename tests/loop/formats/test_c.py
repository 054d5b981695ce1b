"""What stands in exported C code, what it does beside the runtime, and which designs it refuses."""

import made_up
import numpy as np
import pytest
from c_program import together
from exported import texts
from held_back import samples, stepped
from sliding import EVERY
from whole_machines import DESIGNS, happenings, in_c, of_the_runtime
from wording import refused, refused_command

from hfc_design.files.loop_setup import load_design
from hfc_design.formats.connection import connect
from hfc_design.formats.deployment.vectors import vectors

#: A design of every kind of state. All kinds and options are compiled in tests/interop.
STATES = {
    "integral": load_design("jee-koren-2004-pid"),
    "sample before": load_design("lin-lee-1999-table-1"),
    "resonators": made_up.resonating(made_up.linear("lqi", 1), 3, 2.0, 50.0, 900.0),
    "filters": made_up.hierarchy_on_linear(1, notch_hz=60.0, lowpass_hz=150.0),
    "table that adapts": load_design("jee-koren-2004-aflc"),
    "rules that adapt": load_design("jee-koren-1995-soflc"),
    "blame": load_design("huang-soc"),
    "weights": made_up.network(2),
    "moves of a surface": EVERY["within a limit"],
    "root that adapts": made_up.hierarchy(3, adaptation={"k_c": 1e-2, "largest_move": 0.5}),
    "command before": load_design("jee-koren-2004-flc", {"limits.command_rate": 400.0}),
}


def test_one_program_does_what_the_runtime_does(tmp_path):
    nested = DESIGNS["nested"]
    run = together(STATES | {"nested": nested}, tmp_path, "-O0")
    for key, design in STATES.items():
        signals = samples(design, 200)
        expected = stepped(design, signals)
        assert len({*expected}) > 50, key
        found = run(key, np.stack(list(signals.values()), axis=1))
        scale = np.abs(expected).max()
        np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=1e-12, err_msg=key)
    moves = happenings(nested, 200)
    found = run("nested", in_c(nested, moves)).reshape(-1, 2)
    np.testing.assert_allclose(found, of_the_runtime(nested, moves)[1], rtol=1e-12, atol=1e-12)


def test_lookup_needs_c_and_exponentials(tmp_path):
    refused_command("export", "lin-lee-1999-table-1", "--to", "csv", "--lookup", 9)
    for points in (9, 1):
        aflc = ("export", "jee-koren-2004-aflc", "--to", "c", "--out", tmp_path / "c")
        refused_command(*aflc, "--lookup", points)
    assert not (tmp_path / "c").exists()


@pytest.mark.parametrize(
    ("design", "targets"),
    [
        (made_up.level("flc", 1e154), ("c", "st")),
        (made_up.level("soflc", -1e11), ("c", "st")),
        (load_design("pd-only", {"controller.pd.kp": 1e308}), ("c", "st")),
        (load_design("pd-only", {"limits.command": 1e200}), ("c", "st")),
        # An adaptation in which C would differ.
        (made_up.level("aflc", 9.0, error=1e-300, error_change=0.1), ("c",)),
    ],
    ids=["table", "table that adapts", "gain", "limit", "overlap"],
)
def test_what_would_overflow_is_refused(design, targets):
    for target in targets:
        with refused():
            texts(design, target)


def test_hal_has_no_component_of_a_whole_machine_and_an_fmu_a_model_of_its_own():
    with refused():
        texts(DESIGNS["pid"], "linuxcnc")
    with refused():
        texts(STATES["integral"].model_copy(update={"name": "model"}), "fmu")


def test_readings_of_an_encoder_are_rounded_alike_in_single_precision():
    """By hand: a quarter of a step of 50 um from a whole one, in seven digits."""
    made = vectors(connect(load_design("emps-cascade")))
    places = np.array(made.inputs)[:, made.signals.index("position")] / 5e-5
    assert abs(places - np.round(places)) == pytest.approx(np.full(1000, 0.25), abs=0.02)
    assert all(made.tolerance.alike)
