"""What the terminal says of whether a design can be used: the table, the picture, one motion."""

import json

import pytest
from run_folders import hfc

MOTIONS = """
[simulation]
duration_s = 1.0
[fitness]
settled_after_s = 0.6
[[motions]]
name = "ramp"
[[motions]]
name = "creep"
reference = { kind = "ramp", velocity = 0.002 }
duration_s = 0.8
"""


@pytest.fixture
def two(tmp_path):
    """A scenario of two motions without tolerances."""
    (tmp_path / "two.toml").write_text(MOTIONS)
    return tmp_path / "two.toml"


def test_several_motions_within_a_spread_are_told_and_drawn(two, tmp_path):
    given = ["score", "pd-only", "--scenario", two, "--spread", "0.1", "--samples", "12"]
    done = hfc(*given, "--plot", tmp_path / "d.svg")
    assert done.exit_code == 0, done.output
    first, second, *_ = done.stdout.splitlines()
    assert first == "pd-only on two"
    assert second.startswith("Can I use it? ")
    found = json.loads(hfc(*given, "--json").stdout)["can_i_use_it"]
    assert (found["machines"], found["spread"]) == (12, 0.1)
    for name, one in found["motions"].items():
        (row,) = [line for line in done.stdout.splitlines() if line.startswith(f"{name} ")][:1]
        assert float(row.split()[1]) == pytest.approx(100 * one["share"], rel=1e-3)
    picture = (tmp_path / "d.svg").read_text()
    share = f"{100 * found['share']:.4g} % pass"
    for text in (
        "pd-only on two",
        "12 machines within",
        share,
        "settled rms error",
        "chatter",
        "peak command",
    ):
        assert text in picture


def test_a_constraint_that_the_nominal_machine_violates_is_a_no():
    """Table I follows the ramp stably, by far not within a nanoradian."""
    given = ["score", "lin-lee-1999-table-1", "--scenario", "c-axis-ramp", "--spread", "0.01"]
    given += ["--samples", "8", "--set", "simulation.duration_s=1"]
    told = [
        hfc(*given, *more).stdout.splitlines()[1]
        for more in ((), ("--set", "constraints.late_error=1e-9"))
    ]
    assert told[0].startswith("Can I use it? yes: ")
    assert told[1].startswith("Can I use it? no: the nominal machine exceeds late_error")
