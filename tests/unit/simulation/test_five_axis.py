"""Programs and references that five axes cannot follow."""

from pathlib import Path

import pytest
from five_axes import five_axes
from wording import refused

import hfc_design.api as hfc


@pytest.mark.parametrize(
    ("text", "changes"),
    [
        ("G1 X5 F60\nX700", ["x.travel=[-10,600]"]),
        ("G1 X5 F60\nB5", []),
        ("G1 X5", []),
        ("G93 G1 X5 A3", []),
        ("M30", []),
        ("G0 X400", ["x.velocity_per_min=45000"]),
        ("G1 X5 F60", ["x.acceleration_time_s=0.4"]),
        ("G1 X5 F60", ["x.rapid_per_min=3e4", "x.velocity_per_min=2e4"]),
    ],
)
def test_bad_programs_are_one_clear_line(tmp_path, monkeypatch, text, changes):
    monkeypatch.chdir(tmp_path)
    with refused() as found:
        five_axes(Path(), text, *(f"reference.limits.{change}" for change in changes))
    assert "\n" not in found.refusal
    assert ("part.ngc" in found.refusal) == (not changes or "travel" in changes[0])


@pytest.mark.parametrize("change", ["start={w = 1.0}", "acceleration_mm_s2=50"])
def test_keys_that_have_no_meaning_here(tmp_path, change):
    with refused() as found:
        five_axes(tmp_path, "G1 X5 F60", f"reference.{change}")
    assert f"reference.{change[:5]}" in found.refusal


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("five-axis-program", "reference={kind = 'gcode', file = 'part.ngc'}"),
        ("five-axis-program", "reference={kind = 'circle', radius_mm = 5.0, feed_mm_min = 600.0}"),
        ("five-axis-program", "reference={kind='gcode', file='part.ngc', start={x = 1.0}}"),
        ("milling-table-circle", "reference={kind='circle', radius=5}"),  # told at once: two lines
    ],
)
def test_references_that_cannot_be_followed(tmp_path, monkeypatch, name, change):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "part.ngc").write_text("G1 X5 F60")
    with refused() as found:
        hfc.load_scenario(name, [change])
    assert found.refusal.count("\n") == ("radius=" in change)
