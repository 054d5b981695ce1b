"""Run folders that are none, and files that cannot be written."""

import importlib.metadata
import re
import resource
import signal
import tomllib

import pytest
from own_strategies import MODULE
from short_runs import started
from sledge import hfc
from wording import refused, refused_command

from hfc_design import api
from hfc_design.core import checkpoint
from hfc_design.core.records import RunError, UserError
from hfc_design.files.named_scenario import config_toml, load_scenario, scenario_toml
from hfc_design.reference.entries import KEY, things
from hfc_design.runs import run
from hfc_design.runs import run as design


def test_folder_without_a_run_cannot_be_resumed(tmp_path):
    with refused() as found:
        design.opened_run(tmp_path)
    assert found.where == f"folder='{tmp_path}'"


def test_full_disk_loses_nothing(tmp_path):
    """A limit on the size of files stands for the full disk: the same OSError, really raised."""
    path = tmp_path / "file"
    checkpoint.write_whole(path, b"old" * 100)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with refused(RunError):
            checkpoint.write_whole(path, b"new" * 1000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == b"old" * 100


def test_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with refused(RunError):
        started(tmp_path / "file" / "run")


def test_a_run_that_is_refused_at_once_leaves_nothing(tmp_path, monkeypatch):
    def refusing(*_, **__):
        assert (folder / run.CONFIG).is_file()
        raise UserError("the drive cannot be linearised")

    monkeypatch.setattr(run, "run", refusing)
    for folder in (tmp_path / "run", tmp_path):
        done = hfc("design", "c-axis-ramp", "--out", folder, "--quiet")
        assert (done.exit_code, done.stderr) == (2, "hfc: the drive cannot be linearised\n")
        assert [*tmp_path.iterdir()] == []
        with pytest.raises(UserError):
            api.design("c-axis-ramp", folder)
        assert [*tmp_path.iterdir()] == []


def test_a_run_that_is_interrupted_at_once_can_be_resumed(tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "run", interrupted)
    done = hfc("design", "c-axis-ramp", "--out", tmp_path / "run", "--quiet")
    assert done.exit_code == 1
    assert [file.name for file in (tmp_path / "run").iterdir()] == [run.CONFIG]


def test_what_is_commented_changes_nothing(tmp_path):
    scenario = load_scenario("c-axis-practical")
    found = run.new_run(scenario, tmp_path / "run")
    assert found == scenario
    text = (tmp_path / "run" / "config.toml").read_text()
    assert tomllib.loads(text) == tomllib.loads(scenario_toml(scenario))


def test_every_key_is_there(tmp_path):
    text = config_toml(load_scenario("c-axis-ramp"))
    said = {line.split(" =")[0].lstrip("#") for line in text.splitlines() if " = " in line}
    heads = set(re.findall(r"^#?\[+([\w.-]+)\]+$", text, re.MULTILINE))
    for table in ("robust", "constraints", "motions", "windows", "start", "controller.linear"):
        assert table in heads or table in said
    assert {"polish", "spread", "unseen", "observer_hz", "command_rate", "delay_samples"} <= said
    for one in things(KEY):
        parts = [part for part in one.key.split(".") if part != "N"]
        if {"AXIS", "NAME"} & {*parts} or one.key.startswith(("load.sines.N.", "stress.modes.N.")):
            continue
        assert parts[-1] in said | heads or ".".join(parts) in heads, one.key


@pytest.mark.parametrize(
    "arguments",
    [
        ["tracking,speed"],
        ["tracking,effort", "--preset", "race"],
        ["tracking,effort", "--set", "search.preset=lin-lee-1999"],
        ["tracking,units", "--controller", "pd"],
    ],
)
def test_what_cannot_be_traded_is_told_in_a_line(arguments, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert refused_command("design", "c-axis-ramp", "--pareto", *arguments).count("\n") == 1
    assert not [*tmp_path.iterdir()]


def test_the_package_of_an_own_part(own, monkeypatch):
    from hfc_design.core import plugins

    (own / "hunt.py").write_text(MODULE)
    monkeypatch.setattr(plugins, "_distributions", lambda: {"hunt": ["jax"]})
    hfc("list", "strategies", "--strategy", "hunt:CLIMB")
    version = importlib.metadata.version("jax")
    used = [("strategy", "climb"), ("strategy", "race")]
    assert plugins.origins(used) == {"strategy 'climb'": f"jax {version}"}
