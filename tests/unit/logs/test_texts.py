"""What halscope, halsampler and others write, as their sources print it."""

import numpy as np
import pytest
from wording import refused

from hfc_design.logs.reading import read_log

PLACES = [0.125 * k for k in range(30)]


def log_of(tmp_path, text, name="log.csv"):
    path = tmp_path / name
    path.write_text(text)
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


@pytest.mark.parametrize(
    ("separator", "number"),
    [(",", "{:.3f}"), (";", "{:.3f}"), ("\t", "{:.3f}"), (" ", "{:.3f}"), (";", "comma")],
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


GOOD = "t,x\n" + "".join(f"{k},{k * k}\n" for k in range(30))


#: Texts, and the line that is at fault where it is a line.
BAD = {
    "nothing": "",
    "no rows": "t,x\n",
    "one row": "t,x\n1,2\n",
    "word": (GOOD + "30,much\n", 32),
    "short": (GOOD + "30\n", 32),
    "nan": (GOOD + "30,nan\n", 32),
    "inf": (GOOD + "30,-inf\n", 32),
    "overflow": (GOOD + "30,1e999\n", 32),
    "no number": (GOOD + "30,\n", 32),
    "underscore": (GOOD + "30,1_0\n", 32),
    "large": GOOD + "30,1e101\n",
    "twice": GOOD.replace("t,x", "x,x"),
    "escape": GOOD.replace("t,x", "t,x\x1b[31m"),
    "long name": GOOD.replace("t,x", "t," + 300 * "x"),
    "halscope": ("# Sampling period is 1000 ns\n", 2),
    "packed": "\x1f\x8b",
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_log_is_refused_in_a_line(tmp_path, case):
    text, *line = BAD[case] if isinstance(BAD[case], tuple) else (BAD[case],)
    with refused() as found:
        log_of(tmp_path, text)
    assert found.where == str(tmp_path / "log.csv") + "".join(f": line {n}" for n in line)
    assert "\n" not in found.refusal
