"""hfc plot of several: motions of designs, and searches, over one another."""

import json

import numpy as np
import pytest
from run_folders import batch_folder, searched
from wording import refused

from hfc_design.batch.findings import convergence


def test_searches_of_runs_have_distinct_names(tmp_path):
    folders = [searched(tmp_path / name, k + 1.0) for k, name in enumerate(("a/b", "x/b", "x/c"))]
    axes = convergence(folders).axes[0]
    assert axes.get_ylabel() == "best fitness so far"
    labels = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert labels == ["a/b", "x/b", "c"]
    for k, line in enumerate(axes.lines):  # three generations, a third more each
        assert line.get_ydata() == pytest.approx(np.arange(1, 4) * (k + 1) / 3)
    searched(tmp_path / "d", 4.0, "loss")
    axes = convergence([*folders, tmp_path / "d"]).axes[0]
    assert axes.get_ylabel() == "best merit (definitions differ) so far"


def test_searches_of_a_batch_are_the_median_of_each_group(tmp_path):
    values = [[1.0, 2.0, 30.0], [5.0, 6.0, 7.0]]
    groups = [({"search.preset": k}, own) for k, own in zip(("race", "b"), values, strict=True)]
    for name in batch_folder(tmp_path / "out", groups):
        design = json.loads((tmp_path / "out" / name / "design.json").read_text())
        design["score"] |= {"merit": 1.0, "judged_by": "fitness"}
        (tmp_path / "out" / name / "design.json").write_text(json.dumps(design))
    axes = convergence([tmp_path / "out"]).axes[0]
    found = {line.get_label(): line.get_ydata()[-1] for line in axes.lines}
    assert sorted(found.values()) == [2.0, 6.0]
    assert {name.partition(": ")[2] for name in found} == {"preset race", "preset b"}


def test_no_history_and_too_many_curves(tmp_path):
    for k in range(11):
        searched(tmp_path / f"r{k}", k + 1.0)
    with refused():
        convergence(sorted(tmp_path.iterdir()))
    (tmp_path / "r0" / "history.csv").unlink()
    with refused():
        convergence([tmp_path / "r0"])
    with refused():
        convergence([tmp_path / "r1", tmp_path / "r1"])
