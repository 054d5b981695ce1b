"""hfc plot of several: motions of designs, and searches, over one another."""

import json

import numpy as np
import pytest
from run_folders import hfc, run_folder

from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.report.overlaid import motions
from hfc_design.simulation.evaluating import evaluate

SHORT = "simulation.duration_s=0.5"


def evaluated(scenario, *names, changes=(SHORT,)):
    where = load_scenario(scenario, changes)
    return {name: evaluate(load_design(name), where) for name in names}


def lines(axes):
    return {line.get_label(): line for line in axes.lines}


def test_curves_of_one_axis_are_what_was_simulated():
    found = evaluated("c-axis-ramp", "pd-only", "lin-lee-1999-table-1")
    figure = motions(found, "ramp")
    names = [axes.get_ylabel() for axes in figure.axes]
    assert names == ["angle [rad]", "error [mrad]", "deflection [mrad]", "voltage [V]"]
    angle, error, _, voltage = map(lines, figure.axes)
    for name, one in found.items():
        axis = one.axes[0]
        assert angle[name].get_ydata() == pytest.approx(axis.motion.state.spindle_angle)
        assert error[name].get_ydata() == pytest.approx(1e3 * axis.motion.error)
        assert voltage[name].get_ydata() == pytest.approx(axis.motion.command)
    assert angle["reference"].get_ydata()[-1] == pytest.approx(0.02 * 0.499)  # LL section 4.1


def test_a_path_has_contour_errors_and_every_axis():
    found = evaluated("feed-drive-line", "jee-koren-2004-flc", "jee-koren-2004-pid")
    figure = motions(found, "line")
    names = [axes.get_title(loc="right") for axes in figure.axes]
    each = [f"{axis} {what}" for axis in "xy" for what in ("position", "error", "command")]
    assert [name.partition(" [")[0] for name in names] == ["contour error", *each]
    for name, one in found.items():
        assert lines(figure.axes[0])[name].get_ydata() == pytest.approx(one.contour.error)


def test_small_errors_beside_large_ones_have_one_unit():
    """A few µrad and some mrad: both in mrad."""
    found = evaluated("c-axis-ramp", "pd-only")
    axis = found["pd-only"].axes[0]
    motion = axis.motion._replace(error=1e-3 * axis.motion.error)
    found["fine"] = found["pd-only"]._replace(axes=(axis._replace(motion=motion),))
    error = lines(motions(found, "").axes[1])
    both = [error[name].get_ydata() for name in found]
    assert both[1] == pytest.approx(1e-3 * both[0])
    assert np.abs(both[0]).max() == pytest.approx(1e3 * np.abs(axis.motion.error).max())


def searched(path, fitness, title="fitness"):
    """A run folder with a configuration, whose design says what it was ranked by."""
    run_folder(path, fitness)
    (path / "config.toml").write_text(f'name = "mine"\n[run]\nseed = {int(fitness)}\n')
    design = json.loads((path / "design.json").read_text())
    design["score"] |= {"merit": fitness, "judged_by": title}
    (path / "design.json").write_text(json.dumps(design))
    return path


def test_commands(tmp_path):
    out = tmp_path / "a.pdf"
    names = ("pd-only", "lin-lee-1999-table-1")
    done = hfc("plot", *names, "motion", "--set", SHORT, "--out", out)
    assert (done.exit_code, done.stdout) == (0, f"{out}\n")
    assert out.read_bytes().startswith(b"%PDF")
    folders = [searched(tmp_path / name, 1.0) for name in ("a", "b")]
    picture = tmp_path / "b.svg"
    assert hfc("plot", *folders, "convergence", "--out", picture).exit_code == 0
    assert "best fitness so far" in picture.read_text()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("pd-only", "motion"), "motion draws several designs; hfc simulate pd-only --plot"),
        (("pd-only", "lin-lee-1999-table-1", "tree"), "tree: draws one design; convergence and"),
        (("pd-only", "pd-only", "motion"), "pd-only: stands there twice"),
        (("pd-only", "jee-koren-2004-flc", "motion"), "is for the plant feed-drive"),
        (("pd-only", "tree", "--motion", "creep"), "--motion: is not for tree"),
        (("pd-only", "lin-lee-1999-table-1", "motion", "--unit", "x"), "--unit: is not for motion"),
        (("pd-only", "convergence"), "pd-only: is no folder"),
    ],
)
def test_refused(tmp_path, arguments, told):
    done = hfc("plot", *arguments, "--out", tmp_path / "a.png")
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert told in done.stderr
    assert not (tmp_path / "a.png").exists()
