"""Command lines that are refused, of designs whose reading computes: one line each."""

from shlex import split

import pytest
from wording import refused_command

LL, JK = "lin-lee-1999-table-1", "jee-koren-2004"
#: Command line -> what its refusal begins with.
MISTAKES = {
    "attainable feed-drive-circle": "scenario feed-drive-circle",
    f"attainable c-axis-ramp --set limits.command=250 --design {JK}-pid": f"design {JK}-pid",
    "compare": "needs at least two designs",
    "compare pd-only": "needs at least two designs",
    "compare pd-only pd-only": "pd-only",
    "compare pd-only none": "none",
    "compare pd-only pid": "pid",
    "compare pid pd-only": "pid",
    f"compare pd-only {JK}-pid": f"design {JK}-pid",
    f"compare {LL} pd-only --scenario feed-drive-circle": f"design {LL}",
    f"compare {LL} pd-only --scenario none": "none",
    f"compare {LL} pd-only --spread 1.5": "--spread 1.5",
    f"compare {LL} pd-only --machines 0": "--machines 0",
    f"compare {LL} pd-only --out x --html x": "--html x",
    f"compare {LL} pd-only --set sensors.x=1": "c-axis-ramp",
    "design feed-drive-contour --set controller.start=jee-koren-2004-flc": "feed-drive-contour",
    f"plot {JK}-aflc tree --out a.png": f"{JK}-aflc",
    "plot pd-only terms --out a.png": "design pd-only",
    f"plot {LL} surface --unit unit-9 --out a.png": "--unit",
    "plot lin-gai-2009-fuzzy-sliding surface --out a.png": "--axis",
    f"plot {LL} tree --out a.gif": "a.gif",
    f"plot {LL} tree --width 5mm --out b.svg": "--width",
    "plot emps-cascade surface --out a.png": "design emps-cascade",
    "plot huang-cross-coupled surface --out a.png": "design huang-cross-coupled-x",
    "plot huang-soc tree --out a.png": "huang-soc",
    "plot huang-soc surface --axis x --out a.png": "--axis 'x'",
    "plot huang-neural terms --out a.png": "huang-neural",
    "plot pd-only motion --out a.png": "motion draws several designs",
    f"plot pd-only {LL} tree --out a.png": "tree",
    "plot pd-only pd-only motion --out a.png": "pd-only",
    f"plot pd-only {JK}-flc motion --out a.png": f"design {JK}-flc",
    "plot pd-only tree --motion creep --out a.png": "--motion",
    f"plot pd-only {LL} motion --unit x --out a.png": "--unit",
    "plot pd-only convergence --out a.png": "pd-only",
    f"simulate {JK}-flc --learned a.json": f"design {JK}-flc",
    f"simulate {LL} --learned a.json": f"design {LL}",
    "stability no-such-design": "no-such-design",
    "score pd-only --scenario c-axis-ramp --scenario feed-drive-circle": "design pd-only",
    "score pd-only --scenario c-axis-practical --set simulation.sample_time_s=0.002": "design",
    "score pd-only --set simulation.sample_time_s=0.002": "design pd-only",
}


@pytest.mark.parametrize("command", MISTAKES)
def test_a_mistake_is_a_line_and_nothing_is_written(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = refused_command(*split(command))
    assert line.startswith(f"hfc: {MISTAKES[command]}")
    assert line.count("\n") == 1
    assert [*tmp_path.iterdir()] == []
