"""Mistakes in what a script says of a log that it identifies."""

import pytest
from wording import refused

import hfc_design.api as hfc


@pytest.mark.parametrize(
    ("log", "plant", "options"),
    [
        ("log.csv", "c-axis", {"free": ["mas"]}),
        ("log.csv", None, {}),
        ("log.csv", "c-axis", {"columns": ["speed=q"]}),
        (3, "c-axis", {}),
    ],
)
def test_mistakes_are_told_as_the_command_tells_them(log, plant, options, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [f"{k / 1000},{k * k},{k % 7}" for k in range(500)]
    (tmp_path / "log.csv").write_text("\n".join(["time_s,angle_rad,command_V", *rows]))
    with refused():
        hfc.identify(log, plant, **options)
