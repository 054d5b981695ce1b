"""G-code programs, read as LinuxCNC's own interpreter reads them: ``rs274`` prints canonical calls.

It prints four digits of a length, an angle or a feed, in the unit of the program.
"""

import re
import subprocess

import numpy as np
import pytest

from hfc_design.motion import gcode

#: Plane of a canonical arc -> its axes and the third, by their places in X Y Z.
PLANES = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}
CALL = re.compile(r" ([A-Z0-9_]+)\((.*)\)$")

PROGRAMS = {
    "arcs in X-Y": "F500\nG0 X10 Y5\nG2 X20 Y15 I10\nG3 X10 Y25 R10\nG2 X0 Y15 R-10\nG3 X-.001 I9",
    "arcs in Z-X": "G18 F500\nG1 X10\nG2 X15 Z5 I5\nG3 X10 Z10 R5\nG2 X5 Z5 R-5\nG3 X5 Z5 I-5 K1",
    "arcs in Y-Z": "G19 F500\nG1 Y10\nG2 Y15 Z5 J5\nG3 Y10 Z10 R5\nG2 Y5 Z5 R-5\nG3 J-5 K1",
    "helices": "F300\nG2 X10 I5 Z-2 A30\nG18 G3 Z8 K5 Y4 C-20\nG19 G2 Y10 J3 X20\nG17 G3 I2 Z5",
    "turns": "F300\nG2 X10 I5 P2\nG3 X10 Y0 I-3 Z-6 P4\nG18 G3 X0 R5 Y1 P3\nG19 G2 K-2 X9 P2",
    "absolute centres": "G90.1 F9\nG1 X1 Y2 Z3\nG2 X3 I2 J2\nG18 G3 X5 I4 K3\nG91.1 G19 G2 Y4 J1",
    "increments": "G91 F50\nG1 X1 Y2\nX1 Z-1\nG19 G3 Y2 Z2 J2\nG18 G2 X-3 K2 I-1.5 Z4\nG90 G1 X0",
    "inches": "G20 F10\nG1 X1 Y-.5\nG2 X2 I.5\nG18 G3 Z.5 R-.3\nG19 G2 Y1 J.75 X1.5\nG1 A90 F20",
    "units in between": "G21 F100\nG1 X10\nG20 F5\nG2 X1 Y.5 R.5\nG21 G1 F200 X0\nG91 G20 X.1 F2",
    "dwells": "G4 P2\nG1 X5 F100\nG4 P.25\nG4 P.5\nG3 X0 I-2.5\nG1 G4 P1 Y7\nG4 P3\nM5 M9\nY0",
    "feed per revolution": "S800 M3 G95 F.1\nG1 X5\nS50 G2 X9 I2\nM5 G94 F70\nG1 X2\nG95 F.2 M4 X0",
    "inches per revolution": "G20 G95\nS600 M3 F.01 G1 X1\nG18 G2 X2 R.5\nG97 S1200 M3 G3 X1 R.5",
    "inverse time": "G93 G1 X9 A20 F30\nG2 X0 I-4.5 Z3 F5\nG18 G3 Z9 K3 P2 F4\nG1 C5 F9\nG94 X1 F8",
    "what moves nothing": "G64 P.1 Q.1 G97 G40 G80\nG43.1 Z0\nG98 M8\nG1 X1 F60\n(X9)\nG49 G54\nX2",
}


@pytest.fixture
def interpreted(program, tmp_path):
    """Motions as LinuxCNC makes them: end, feed, rest; plane, centre and turns of arcs."""
    rs274 = program("rs274")

    def run(text):
        for name, content in (("a.ngc", f"{text}\nM2\n"), ("a.var", ""), ("a.tbl", "")):
            (tmp_path / name).write_text(content)
        command = [rs274, "-g", "-v", "a.var", "-t", "a.tbl", "a.ngc", "out"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        calls = [CALL.search(line) for line in (tmp_path / "out").read_text().splitlines()]
        return motions([(call[1], re.findall(r"[-\w.]+", call[2])) for call in calls if call])

    return run


def motions(calls):
    """The motions among canonical calls, in mm, deg and minutes."""
    place, unit, plane, rest, feed, spindle, per_turn = np.zeros(6), 1.0, None, 0.0, 0.0, 0.0, False
    for name, words in calls:
        if name == "USE_LENGTH_UNITS":
            unit = 25.4 if words == ["CANON_UNITS_INCHES"] else 1.0
        elif name == "SELECT_PLANE":
            plane = PLANES[words[0].rpartition("_")[2]]
        elif name == "SET_FEED_MODE":
            per_turn = words[1] == "1"
        elif name == "SET_FEED_RATE":
            feed = float(words[0])
        elif name == "SET_SPINDLE_SPEED":
            spindle = float(words[1])
        elif name == "DWELL":
            rest += float(words[0])
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "ARC_FEED"):
            numbers, arc = np.array(words, float), None
            if name == "ARC_FEED":
                end = numbers[[0, 1, 5, 6, 7, 8]]
                end[[*(plane or PLANES["XY"])]] = numbers[[0, 1, 5]]
                arc = plane or PLANES["XY"], unit * numbers[2:4], numbers[4]
            else:
                end = numbers
            end[:3] *= unit
            if arc or not np.allclose(end, place, atol=1e-9):
                linear = arc or not np.allclose(end[:3], place[:3], atol=1e-9)
                rate = feed * (unit if linear else 1.0) * (spindle if per_turn else 1.0)
                yield end, None if name == "STRAIGHT_TRAVERSE" else rate, rest, arc
                rest = 0.0
            place = end


@pytest.mark.parametrize("name", PROGRAMS)
def test_motions_are_those_of_linuxcnc(interpreted, name):
    expected, place = [*interpreted(PROGRAMS[name])], np.zeros(6)
    found = gcode.blocks(PROGRAMS[name])
    assert len(found) == len(expected) >= 2
    for block, (end, feed, rest, arc) in zip(found, expected, strict=True):
        assert block.start == pytest.approx(place, abs=2e-3)
        assert block.end == pytest.approx(end, abs=2e-3)
        assert block.feed == (feed if feed is None else pytest.approx(feed, rel=1e-3))
        assert block.rest == pytest.approx(rest)
        assert (block.centre is None) == (arc is None)
        if arc:
            plane, centre, turns = arc
            assert block.plane == plane[:2]
            assert block.centre == pytest.approx(centre, abs=2e-3)
            first, last = (complex(*(at[[*plane[:2]]] - centre)) for at in (place, end))
            part = np.sign(turns) * np.angle(last / first) % (2 * np.pi)
            part = part if part > 1e-3 else 2 * np.pi
            sweep = np.sign(turns) * (part + 2 * np.pi * (abs(turns) - 1))
            assert block.sweep == pytest.approx(sweep, abs=2e-3)
        place = end
