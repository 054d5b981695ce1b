"""Variables of a shell that are nonsense, and a file that is named as a package of ours."""

import os
import subprocess
import sys

import pytest

SHORT = ("score", "pd-only", "--set", "simulation.duration_s=0.1")


def hfc(folder, arguments, **variables):
    """What ``python -m hfc_design`` does in a folder."""
    return subprocess.run(
        [sys.executable, "-m", "hfc_design", *arguments],
        env={**os.environ, **variables},
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize(
    ("name", "value"), [("JAX_NUM_CPU_DEVICES", "abc"), ("JAX_PLATFORMS", "nonsense")]
)
def test_a_variable_that_nothing_can_be_computed_with_is_a_line(tmp_path, name, value):
    done = hfc(tmp_path, SHORT, **{name: value})
    assert done.returncode != 0
    assert done.stderr.startswith(f"hfc: {name}={value}: ")
    assert len(done.stderr.splitlines()) == 1
    assert len(done.stderr) <= 301


def test_others_change_nothing(tmp_path):
    """Nor does a file that is named as a package of ours is."""
    (tmp_path / "plants.py").write_text("raise SystemExit('mine')")
    done = hfc(tmp_path, SHORT, COLUMNS="0", MPLBACKEND="nonsense")
    assert done.returncode == 0, done.stderr
    assert "peak_voltage_V" in done.stdout
    drawn = ("simulate", *SHORT[1:], "--plot", "x.png")
    done = hfc(tmp_path, drawn, MPLBACKEND="nonsense")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "x.png").stat().st_size > 1000
