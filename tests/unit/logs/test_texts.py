"""What halscope, halsampler and others write, as their sources print it."""

import numpy as np
import pytest
from wording import refused

from hfc_design.logs.reading import read_log

PLACES = [0.125 * k for k in range(30)]


def log_of(tmp_path, text, name="log.csv", encoding="utf-8"):
    path = tmp_path / name
    path.write_text(text, encoding)
    return read_log(path)


def test_halscope(tmp_path):
    """scope_files.c of LinuxCNC 2.9: names, then two lines of settings, then numbers."""
    head = "# Sampling period is 1000000 ns\njoint.0.motor-pos-fb;pid.x.output\n"
    settings = "# Position: 0.5;0.25\n# Scale: 3;0\n"
    rows = "".join(f"{x:+.14f};{-x:+.14f}\n" for x in PLACES)
    log = log_of(tmp_path, head + settings + rows)
    assert (log.sample_time, log.format) == (pytest.approx(1e-3), "halscope")
    assert [*log.columns] == ["joint.0.motor-pos-fb", "pid.x.output"]
    np.testing.assert_array_equal(log.columns["pid.x.output"], -np.array(PLACES))


@pytest.mark.parametrize("interlaced", [True, False])
def test_older_halscope(tmp_path, interlaced):
    """Its two orders, and the sample of the first channel that it writes beyond the last."""
    one, two = (
        [f"{name} {sign * x:+.14f} " for x in PLACES] for name, sign in (("a", 1), ("b", -1))
    )
    lines = ["".join(pair) for pair in zip(one, two, strict=True)] if interlaced else [*one, *two]
    lines += ["a +9.00000000000000 "] if interlaced else []
    log = log_of(tmp_path, "\n".join(["Sampling period is 50000 nSec ", "", *lines]))
    assert log.sample_time == pytest.approx(5e-5)
    np.testing.assert_array_equal(log.columns["a"], PLACES)
    np.testing.assert_array_equal(log.columns["b"], -np.array(PLACES))


def test_halsampler_says_where_samples_were_lost(tmp_path):
    lines = [f"{k} {x:.6f} {-x:.6f}" for k, x in enumerate(PLACES)]
    lines.insert(12, "overrun")
    log = log_of(tmp_path, "\n".join(lines) + "\n", "samples.txt")
    assert (log.format, log.rows, [*log.columns]) == (
        "halsampler",
        30,
        ["column_1", "column_2", "column_3"],
    )
    assert np.flatnonzero(log.breaks).tolist() == [12]


def test_a_gap_is_where_it_is_said_to_be_below_a_head_too(tmp_path):
    """Twice at one place, and at the end, behind which nothing comes."""
    lines = ["made by a machine", "t,x", "s,mm", *(f"{k},{k * k}" for k in range(30))]
    for place in (33, 15, 15):
        lines.insert(place, "overrun")
    log = log_of(tmp_path, "\n".join(lines))
    assert [x[log.breaks].tolist() for x in log.columns.values()] == [[12.0], [144.0]]


#: Of lines of an older halscope that are lost or cut: both orders.
TURNS = [f"a {k}.5 b {-k}.5 " for k in range(30)]
CHANNELS = [f"{name} {k}.5 " for name in "ab" for k in range(30)]


@pytest.mark.parametrize(
    ("lines", "at", "now", "line"),
    [
        (TURNS, 12, "a 12.5 b ", 14),
        (TURNS, 12, "a 12.5 ", 15),
        (TURNS, 29, "b -29.5", 31),
        (CHANNELS, 12, "a ", 14),
        (CHANNELS, 12, "", None),
        (CHANNELS, 59, "", None),
    ],
)
def test_a_lost_value_of_an_older_halscope_shifts_nothing(tmp_path, lines, at, now, line):
    changed = [*lines[:at], *([now] if now else []), *lines[at + 1 :]]
    with refused() as found:
        log_of(tmp_path, "\n".join(["Sampling period is 50000 nSec ", *changed]))
    assert found.where == str(tmp_path / "log.csv") + (f": line {line}" if line else "")


@pytest.mark.parametrize(
    ("separator", "number"),
    [(",", "{:.3f}"), ("\t", "{:.3f}"), (";", "comma")],
)
def test_columns_between_any_separator(tmp_path, separator, number):
    """A decimal comma too, as a spreadsheet writes it in much of Europe."""
    form = (lambda x: f"{x:.3f}".replace(".", ",")) if number == "comma" else number.format
    rows = [separator.join(map(form, (x, -x))) for x in PLACES]
    quoted = '"' if separator == "," else ""
    head = separator.join(f"{quoted}{name}{quoted}" for name in ("x[mm]", "u"))
    log = log_of(tmp_path, "\n".join(["# made by a machine", head, *rows]))
    np.testing.assert_array_equal(log.columns["x[mm]"], PLACES)
    np.testing.assert_array_equal(log.columns["u"], -np.array(PLACES))


#: How programs write a table of t and x, and what of it is no row of numbers.
SQUARES = [f"{k / 8},{k * k / 8}" for k in range(40)]
COMMAS = [row.replace(",", ";").replace(".", ",") for row in SQUARES]
FORMS = {
    "units": (["t,x", "s,mm", *SQUARES], "t [s]", "x [mm]"),
    "units in brackets": (["t_s,x", "[s],(mm/s)", *SQUARES], "t_s", "x [mm/s]"),
    "one without a unit": (["t,x,n", "s,mm,-", *(f"{row},{row[:1]}" for row in SQUARES)], "t [s]"),
    "lines above": (["Recorder: X", "Sampling: 1 ms", "", "t,x", *SQUARES],),
    "filled lines above": (["Recorder,7", ",", "t,x", "s,m", *SQUARES], "t [s]", "x [m]"),
    "sep=;": (["sep=;", "t;x", *COMMAS],),
    "quoted sep": (['"sep=,"', "t,x", *SQUARES],),
    "trailing": (["t,x,", *(f"{row}," for row in SQUARES)],),
    "trailing below": (["t,x", *(f"{row},," for row in SQUARES)],),
    "state": (["t,state,x", *(row.replace(",", ',"RUN, 1",') for row in SQUARES)],),
    "late comma": (["t;x", *(f"{k};{k}" for k in range(25)), *COMMAS],),
    "channel numbers": (["t,1", *SQUARES], "t", "1"),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("form", FORMS)
def test_what_stands_around_the_numbers_is_no_number(tmp_path, form, encoding):
    lines, *names = FORMS[form]
    log = log_of(tmp_path, "\n".join(lines), encoding=encoding)
    columns = [*log.columns.items()]
    assert [name for name, _ in columns][: len(names or "tx")] == (names or ["t", "x"])
    for power, (_, values) in enumerate(columns[:2], 1):
        np.testing.assert_array_equal(values[-40:], np.arange(40) ** power / 8)
    assert log.texts == (("state",) if form == "state" else ())


GOOD = "t,x\n" + "".join(f"{k},{k * k}\n" for k in range(30))


#: Texts, and the line that is at fault where it is a line.
BAD = {
    "nothing": "",
    "one row": "t,x\n1,2\n",
    "word": (GOOD + "30,much\n", 32),
    "short": (GOOD + "30\n", 32),
    "inf": (GOOD + "30,-inf\n", 32),
    "underscore": (GOOD + "30,1_0\n", 32),
    "large": GOOD + "30,1e101\n",
    "first row": ("t,x,y\n0,,0\n" + "1,2,3\n" * 30, 2),
    "first row without names": ("0,x,0\n" + "1,2,3\n" * 30, 1),
    "head of others": ("a;b\n" + "1,2,3\n" * 30, 1),
    "number in a text": ("t,x,state\n" + "1,2,RUN\n" * 99 + "1,2,3\n", 101),
    "comma and blanks": ("0,5 1,5\n" * 30, 1),
    "comma and point": ("t;x\n" + "0.5;1\n" * 30 + "0,5;1\n", 32),
    "thousands": ("t;x\n" + "1,5;1\n" * 30 + "1.234,5;1\n", 2),
    "very wide": "1,2," * 999 + "1\n" + "1," * 3996 + "1\n",
    "twice": GOOD.replace("t,x", "x,x"),
    "long name": GOOD.replace("t,x", "t," + 300 * "x"),
    "halscope": ("# Sampling period is 1000 ns\n", 2),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_log_is_refused_in_a_line(tmp_path, case):
    text, *line = BAD[case] if isinstance(BAD[case], tuple) else (BAD[case],)
    with refused() as found:
        log_of(tmp_path, text)
    assert found.where == str(tmp_path / "log.csv") + "".join(f": line {n}" for n in line)
    assert "\n" not in found.refusal
