"""The codes of G-code: which change nothing here, which are read with a note, which are refused.

After LinuxCNC's reference, https://linuxcnc.org/docs/html/gcode.html.
"""

#: Units, planes and modes: exact path, look-ahead; no offsets, no compensation.
IDLE_G = frozenset({5.1, 40, 49, 54, 61, 80, 94, 17, 18, 19, 20, 21, 90, 91, 90.1, 91.1, 93})
IDLE_M = frozenset({0, 1, 3, 4, 5, 6, 7, 8, 9, 48, 49})  # stops, spindle, tool, coolant, override
ENDS = frozenset({2, 30})
#: What is read, although a machine may do something else -> how it is read.
NOTED_G = {
    4: "the dwell is left out",
    43: "the length of the tool is taken as 0",
    64: "corners are not rounded, the path is exact and slower in them",
}
NOTED_BLOCK = "blocks that begin with / are carried out"
#: Words that belong to a code, and mean nothing without it.
PARAMETERS: dict[float, str] = {4: "P", 5.1: "Q", 43: "H", 64: "PQ"}
#: Codes that are refused, and why.
_DRILLING = "drilling cycles are not read; write their moves with G0 and G1"
_OFFSET = "of the offsets of a workpiece only G54 is read"
_MACHINE = "positions of the machine are not known here; write the move in X, Y, Z"
OTHER_G: dict[float, str] = {
    **dict.fromkeys(
        (41, 41.1, 42, 42.1), "the tool's radius is not compensated; write its centre's path"
    ),
    **dict.fromkeys((43.1, 43.2), "the length of a tool is not read, only G43 and G49"),
    **dict.fromkeys((55, 56, 57, 58, 59, 59.1, 59.2, 59.3, 10, 52, 92), _OFFSET),
    **dict.fromkeys((28, 28.1, 30, 30.1, 53), _MACHINE),
    **dict.fromkeys((73, 74, 81, 82, 83, 84, 85, 86, 87, 88, 89), _DRILLING),
    **dict.fromkeys((5, 5.2, 5.3), "splines are not read; write them as G1, G2 and G3"),
    33: "threads are not read",
    38.2: "probing is not read",
    61.1: "a stop after every block is not simulated, only the exact path (G61)",
    76: "threads are not read",
    95: "a feed per revolution is not read, only per minute (G94)",
}
OTHER_M: dict[float, str] = {
    **dict.fromkeys((97, 98, 99), "subprograms are not read; write their moves out"),
}
PLANES = {17: "X-Y", 18: "X-Z", 19: "Y-Z"}
#: [mm] of a unit of length.
UNITS = {20: 25.4, 21: 1.0}
