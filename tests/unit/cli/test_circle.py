"""``hfc circle`` on logs: which part counts, what the numbers are, what is refused."""

import json
from functools import partial

import numpy as np
import pytest
from run_folders import hfc
from wording import refused_command

circle, refused = partial(hfc, "circle"), partial(refused_command, "circle")
RADIUS, FEED, EVERY = 40.0, 1200.0, 0.002
TURN = 2.0 * np.pi
#: 450 deg and back, from a place outside along a line, with rests [rad].
ANGLES = np.concatenate([np.linspace(0.0, 1.25 * TURN, 6250), np.full(50, 1.25 * TURN)])
ANGLES = np.concatenate([ANGLES, ANGLES[::-1]])


def log(path, squareness=0.0, angles=ANGLES, head="time_s,x_position_mm,y_position_mm", **more):
    """A log of a circle about (100, -20) of which X is off by ``squareness`` times Y [1]."""
    x, y = RADIUS * np.cos(angles), RADIUS * np.sin(angles)
    columns = [x + squareness * y + 100.0, y - 20.0, *more.get("others", ())]
    line = np.linspace([150.0, 30.0], [columns[0][0], columns[1][0]], 300).T
    line = [*line, *(np.full(300, one[0]) for one in columns[2:])]
    columns = [np.concatenate(pair) for pair in zip(line, columns, strict=True)]
    time = EVERY * np.arange(len(columns[0])) * (TURN * RADIUS / (FEED / 60.0) / EVERY / 5000)
    np.savetxt(path, np.stack([time, *columns], axis=1), "%.6f", ",", header=head, comments="")
    return path


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_log_without_reference():
    """Squareness of 0.5 mm/m: +-10 um at 45 deg, which the minimum zone has as a whole."""
    found = json.loads(circle(log("log.csv", 5e-4), "--radius", RADIUS, "--json").stdout)
    assert found["feed_mm_min"] == pytest.approx(FEED, rel=2e-3)
    for key in ("G(XY)", "G(YX)", "G(b)"):
        assert found["deviations_mm"][key] == pytest.approx(0.02, abs=1e-5)
    assert found["deviations_mm"]["Fmax(XY)"] == pytest.approx(0.01, rel=2e-3)
    assert found["largest"] == "squareness"
    assert found["causes"]["squareness"]["detail"] == "angle 500 µm/m too small"
    assert found["notes"] == [
        "No reference in the log: centre offset cannot be told, as the nominal circle is fitted."
    ]
    assert found["passes"] is None


def test_the_reference_tells_the_centre_and_other_names_are_told():
    x, y = 100.3 + RADIUS * np.cos(ANGLES), -20.0 + RADIUS * np.sin(ANGLES)
    log("log.csv", head="t [ms],ax,ay,x_reference,set y [um]", others=(x, 1e3 * y))
    columns = ("x=ax [mm]", "y=ay", "y_reference=set y [um]")
    given = [part for one in columns for part in ("--column", one)]
    done = circle("log.csv", *given, "--limit", "G=0.001", "--limit", "F=0.1")
    found = {row.split()[-1] for row in done.stdout.splitlines() if "deviation " in row}
    assert {"pass", "fail"} <= found  # it is round, and 0.3 mm off
    causes = json.loads(circle("log.csv", *given, "--json").stdout)["causes"]
    assert causes["centre offset"]["size_mm"] == pytest.approx(0.6, abs=1e-4)


def test_chart_and_page():
    log("log.csv", angles=ANGLES[:6300])
    done = circle("log.csv", "--plot", "a.png", "--pdf", "b.pdf", "--about", "machine: $7_8")
    assert done.stdout.splitlines()[-2:] == ["a.png", "b.pdf"]
    assert "One direction alone" in done.stdout
    with open("b.pdf", "rb") as file:
        assert b"/MediaBox [ 0 0 595.44 841.68 ]" in file.read()  # A4 in points


def test_what_is_no_circle_is_refused():
    line = np.linspace(0.0, 1.0, 500)
    np.savetxt("line.csv", np.stack([line, line], 1), header="x,y", delimiter=",", comments="")
    assert refused("line.csv").where == "line.csv"
    assert refused(log("arc.csv", angles=ANGLES[:3000])).where == "arc.csv"
    assert refused(log("few.csv", angles=ANGLES[:6300:80])).where == "few.csv"
    one = log("one.csv", head="time_s,x_mm,q")
    assert refused(one).where == "one.csv"
    assert refused(one, "--column", "y=nix").where == "one.csv"
    assert refused(one, "--column", "y=q", "--limit", "Gb").where == "--limit Gb"
    assert refused(one, "--column", "y=q", "--limit", "Q=1").where == "one.csv"
    assert refused(one, "--column", "y=q", "--limit", "G=0").where == "--limit G=0"
    assert refused(one, "--radius", "0").where == "--radius 0.0"
    assert (
        refused(one, "--set", "plant.parameters.mass=1").where == "--change, --scenario and --set"
    )
    assert refused("nix").where == "nix"
