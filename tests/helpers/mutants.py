"""Files of users, and what becomes of them: bits, bytes and words flipped, lost, repeated, huge."""

import re

from imported_files import GAUSSIAN, OCTAVE, PYFUZZYLITE, TEXTS
from places import ROOT

from hfc_design.files.design import BUILTIN as DESIGNS
from hfc_design.files.named_scenario import BUILTIN as SCENARIOS

BATCHES = ROOT / "experiments"
WORD = re.compile(rb"\w[\w.+-]*|\s+|.", re.DOTALL)
NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][+-]?\d+)?")
#: Numbers at which arithmetic, floats and integers end.
NUMBERS = (
    b"0 -0.0 1 -1 7 1e308 -1e308 1e309 1e-320 5e-324 1e-308 1e154 1e-154 1e9 -1e-9 inf -inf nan"
)
NUMBERS = (NUMBERS + b" NaN Infinity 9223372036854775808 4294967296 0x7f 1_000 1e999 .5").split()
NUMBERS += [b"9" * 400, b"1" * 5000, b"0." + b"0" * 400 + b"1", b"1e" + b"9" * 50]
#: Letters that move a terminal, end a line, are half a letter or none.
STRANGE = ["\0", "\x1b[31m", "\r", "\x0b", "\x85", "\u2028", "\u202e", "\ufeff", "\u0661", "\xa0"]
STRANGE += ["é", "\U0001f600", "\x7f", "\u200b", "a\u0301", "''", '"', "\\ud800", "\\u0000", '"""']
STRANGE = [letter.encode() for letter in STRANGE] + [b"\xff", b"\xed\xa0\x80", b"\xc3", b"\xf0\x9f"]
OPENING = [
    b"[",
    b"{",
    b'{"a":',
    b"[[",
    b"(",
    b"{a=",
    b"a.",
    b"'",
    b'"',
    b"=",
    b",",
    b" ",
    b"\n",
    b"#",
]
#: Bytes of a file after everything: what a user may write by hand, and more.
LONGEST = 40_000


def mutant(rng, seeds, blocks=LONGEST):
    """One of the seeds with up to four mutations; ``blocks`` are the longest repetitions."""
    text = rng.choice(seeds)
    for _ in range(rng.choice((1, 1, 1, 2, 2, 4))):
        text = rng.choice(KINDS)(rng, text, seeds, blocks)[:LONGEST]
    return text


def _place(rng, text, longest=80):
    begin = rng.randrange(len(text) + 1)
    return begin, min(begin + rng.randrange(longest), len(text))


def _flipped(rng, text, *_):
    k = rng.randrange(len(text) or 1)
    return text[:k] + bytes(b ^ 1 << rng.randrange(8) for b in text[k : k + 1]) + text[k + 1 :]


def _lost(rng, text, *_):
    begin, end = _place(rng, text)
    return text[:begin] + text[end:]


def _broken_off(rng, text, *_):
    return text[: rng.randrange(len(text) + 1)]


def _repeated(rng, text, _, blocks):
    begin, end = _place(rng, text)
    most = blocks // max(end - begin, 1)
    times = rng.choice((1, 1, 2, 7, 49)) if rng.random() < 0.8 else most
    return text[:end] + text[begin:end] * min(times, most) + text[end:]


def _moved(rng, text, *_):
    (begin, end), where = _place(rng, text), rng.randrange(len(text) + 1)
    return text[:where] + text[begin:end] + text[where:]


def _spliced(rng, text, seeds, _):
    other = rng.choice(seeds)
    return text[: rng.randrange(len(text) + 1)] + other[rng.randrange(len(other) + 1) :]


def _another_word(rng, text, *_):
    words = list(WORD.finditer(text, *_place(rng, text, 400)))
    if not words:
        return text
    one, other = rng.choice(words), rng.choice(words)
    return text[: one.start()] + other[0] + text[one.end() :]


def _another_number(rng, text, *_):
    found = list(NUMBER.finditer(text, rng.randrange(len(text) + 1)))
    if not found:
        return text + rng.choice(NUMBERS)
    one = rng.choice(found[:40])
    return text[: one.start()] + rng.choice(NUMBERS) + text[one.end() :]


def _strange(rng, text, *_):
    begin, end = _place(rng, text, 3)
    return text[:begin] + rng.choice(STRANGE) + text[end:]


def _deep(rng, text, _, blocks):
    begin, one = rng.randrange(len(text) + 1), rng.choice(OPENING)
    times = min(rng.choice((3, 60, 3000)), max(blocks // len(one), 1))
    return text[:begin] + one * times + text[begin:]


KINDS = [_flipped, _lost, _broken_off, _repeated, _moved, _spliced, _another_word]
KINDS += [_another_number, _another_number, _strange, _deep]

TOML = [path.read_bytes() for path in sorted(SCENARIOS.glob("*.toml"))]
TOML.append(b"""name = "all"
[plant]
name = "feed-drive"
axes = { x = {}, y = { gain = 30.0 } }
[reference]
kind = "per-axis"
[reference.axes.x]
kind = "trapezoidal"
distance = 500
velocity = 100.0
acceleration = 2e3
[reference.axes.y]
kind = "sine"
amplitude = 10
frequency_rad_s = 3.0
[load]
constant = 1.0
sines = [{ amplitude = 1.0, frequency_rad_s = 2.0, phase_rad = 0.5 }]
[load.axes.y]
constant = 2.5
[sensors]
encoder_resolution = 1.0
noise = 0.1
[limits]
command = 600.0
[simulation]
duration_s = 2.0
sample_time_s = 0.01
substeps = 2
[[windows]]
name = "late"
from_s = 1.0
to_s = 2.0
""")
GCODE = [(SCENARIOS / "feed-drive-contour.ngc").read_bytes()]
GCODE.append(
    b"%\nN1 G21 G90 (start) F300\nG0 X1 Y2 ; rapid\nG2 X3 Y2 I1 J0 P2\n"
    b"G4 P.5\nG91 G3 X1 Y1 R2.5\nM2\n"
)
JSON = [path.read_bytes() for path in sorted(DESIGNS.glob("*.json"))]
FLL = [PYFUZZYLITE.read_bytes(), GAUSSIAN.read_bytes(), TEXTS["fll"].encode()]
FIS = [OCTAVE.read_bytes(), TEXTS["fis"].encode()]
BATCH = [
    b"""description = "two"
set = { scenario = "feed-drive-line", search.generations = 2 }
grid = { "search.population" = [64, 128], run.seed = [0, 1] }
[[published]]
quantity = "merit"
metric = "merit"
value = 1.5
of = { run.seed = 1 }
"""
]
BATCH.append(b"""name = "scored"
[[cells]]
label = "flc"
design = "jee-koren-2004-flc"
change.controller.integral_gain = 3.0
[[cells]]
label = "pid"
scenario = "feed-drive-circle"
design = "jee-koren-2004-pid"
[grid]
plant.parameters.gain = [28.3, 30]
""")
PLAN = [
    b"""{"cells": {"0a1b2c3d4e5f6a7b": {"scenario": "c-axis-ramp", "run.seed": 3,
 "label": "a"}}, "files": {"mine": {"description": "x", "published": [{"figure": "1",
 "quantity": "q", "value": 1.5, "metric": "merit", "of": {"label": "a"}, "over": {}}]}}}"""
]
CSV = [b"time_s,load\n0,0\n0.5,1.25\n1.0,-3e1\n2,4\n", b"0.0,1\n1,2\n5,2\n", b"\xef\xbb\xbf0;1\n"]
CONFIG = [b'name = "one"\nrun.seed = 3\n[search]\npopulation = 64\n[reference]\nkind = "ramp"\n']
HISTORY = [b"generation,best,median,diverged,structures\n0,1.5,0.5,3,7\n1,2.5,nan,0,1\n2,3,1,0,1\n"]
SET = [b"simulation.duration_s=5", b"plant.parameters.spindle_inertia=6.5", b"search.population=64"]
SET += [b"description='a text'", b"reference={kind='sine', amplitude=1.0, frequency_rad_s=2.0}"]
SET += [b"windows=[{name='a', from_s=0.0, to_s=1.0}]", b"sensors.velocity='encoder'"]
SET += [b"sensors={velocity='observer', observer_hz=50.0, readings={current={noise=0.1}}}"]
SET += [b"limits={command=9.0, resolution=0.5, delay_samples=1}"]
OTHER = [
    b"controller.integral_gain=8",
    b"plant.parameters.gain=30",
    b"name='mine'",
    b"limits.command=2",
]
OTHER += [
    b"controller.rules.centroids=[[1,2],[3,4]]",
    b"provenance.x={a=[1,'b']}",
    b"score.fitness=1",
]
AT = [b"error=12,error_change=1.5", b"error = -3e-1 , previous_error=2", b"error=1,velocity=2"]
OBJECT = [b"toy_machine:MACHINE", b"mine.part:Thing.inner", b"no_such_module:x", b":", b"a:b:c"]
OBJECT += [b"hfc_design.core.plugins:GROUPS", b"math:pi"]
