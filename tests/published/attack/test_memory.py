"""Runs that no machine has the memory for are refused at once, before anything is written."""

from types import SimpleNamespace

import pytest
from attack import Attack
from batches import batch, written
from run_folders import hfc

from hfc_design import api
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.problem import check_memory
from hfc_design.simulation import memory

LONG = "simulation.duration_s=10000"  # ten million samples
DESIGN = ("design", "c-axis-ramp", "--quiet")
SCORE = ("score", "lin-lee-1999-table-1")
TOO_LARGE = [
    (*DESIGN, "--population", "10000000"),
    (*DESIGN, "--population", "1000000000"),
    (*DESIGN, "--set", "simulation.duration_s=1e9"),
    (*DESIGN, "--set", LONG, "--memory", "20GB"),
    (*SCORE, "--set", LONG, "--set", "simulation.substeps=1000"),
    ("simulate", *SCORE[1:], "--set", LONG, "--set", "simulation.substeps=1000"),
    (*SCORE, "--spread", "0.1", "--samples", "1000000000000"),
    (*SCORE, "--spread", "0.1", "--samples", "1000000", "--memory", "2 GB"),
    *((*DESIGN, "--memory", text) for text in ("0", "-1GB", "1e99GB", "quark", "9" * 400)),
]


@pytest.fixture(autouse=True)
def bound(monkeypatch):
    """--memory sets a variable that workers inherit; no test leaves one behind."""
    monkeypatch.setenv(memory.VARIABLE, "16GB")


def test_what_is_too_large_ends_at_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    attack = Attack("memory")

    def refused(*arguments):
        monkeypatch.setenv(memory.VARIABLE, "16GB")
        done = hfc(*arguments)
        assert done.exit_code == 2, done.output
        assert done.stderr.startswith("hfc: ")
        assert done.stderr.count("\n") == 1
        assert len(done.stderr) < 400
        assert not list(tmp_path.iterdir())
        return "refused"

    for arguments in TOO_LARGE:
        attack.input(refused, *arguments)
    attack.end()


def test_a_batch_counts_its_workers(tmp_path, monkeypatch):
    text = "[set]\nsearch.population = 100000\n[grid]\nrun.seed = [0, 1]\n"
    file = written(tmp_path, text)
    done = batch(file, "--out", tmp_path / "out", "--memory", "3GB", "--workers", "2")
    assert done.exit_code == 2
    assert "the limit is 3 GB (--memory or HFC_MEMORY: 3GB)" in done.stderr
    assert "most by search.population; " in done.stderr
    assert not (tmp_path / "out").exists()
    scenario = load_scenario("c-axis-ramp", {"search.population": 100_000})
    check_memory(scenario)
    monkeypatch.setenv(memory.VARIABLE, "3GB")
    check_memory(scenario)
    with pytest.raises(UserError, match="needs about"):
        check_memory(scenario, at_once=2)


def test_a_script_is_refused_too(monkeypatch):
    monkeypatch.setenv(memory.VARIABLE, "100MB")
    for function in (api.evaluate, lambda *names: api.robustness(*names, 0.1, 10)):
        with pytest.raises(UserError, match=r"the limit is 0\.1 GB"):
            function("lin-lee-1999-table-1", "c-axis-ramp")
    with pytest.raises(UserError, match=r"the limit is 0\.1 GB"):
        api.design("c-axis-ramp")


def test_the_bound_of_a_control_group_counts(monkeypatch):
    """As in a container of 4 GB that has used 3, 1 of it for files that can be dropped."""
    files = {
        "/proc/self/cgroup": "0::/a/b\n",
        "/sys/fs/cgroup/a/b/memory.max": "max\n",
        "/sys/fs/cgroup/a/b/memory.current": "2\n",
        "/sys/fs/cgroup/a/memory.max": "4000000000\n",
        "/sys/fs/cgroup/a/memory.current": "3000000000\n",
        "/sys/fs/cgroup/a/memory.stat": "anon 5\ninactive_file 1000000000\n",
    }
    monkeypatch.setattr(memory, "_text", lambda path: files.get(str(path), ""))
    used = SimpleNamespace(memory_info=lambda: SimpleNamespace(rss=1_024_000_000))
    monkeypatch.setattr(memory.psutil, "Process", lambda: used)
    total = SimpleNamespace(available=50_000_000_000)
    monkeypatch.setattr(memory.psutil, "virtual_memory", lambda: total)
    assert memory.free() == 2e9 + 1.024e9
    files["/proc/self/cgroup"] = "4:memory:/x\n0::/\n"
    files["/sys/fs/cgroup/memory/x/memory.limit_in_bytes"] = "3000000000\n"
    files["/sys/fs/cgroup/memory/x/memory.usage_in_bytes"] = "2500000000\n"
    assert memory.free() == 0.5e9 + 1.024e9
    files.clear()
    assert memory.free() == 50e9 + 1.024e9
