"""The examples and the page on Python run as they stand, on a small budget."""

import re
import runpy
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from places import ROOT

from hfc_design.cli import main

EXAMPLES = ROOT / "examples"
#: What each of them prints at least.
PRINTS = {
    "01_design_and_export": [r"fitness [\d.]+ where", "lin-lee-1999-table-1: rms error", "motion"],
    "02_own_plant": [r"fuzzy hierarchy: largest error \d+ um", r"best PD: .* \d+ um"],
    "03_own_controller": [r"cascade, searched: contour error [\d.]+ BLU", "pid of 2004"],
    "04_own_fitness": [r"lin-lee: kp \d+", r"gentle: kp \d+"],
    "05_own_machine": [r"unbalance 0.3 kg m: rms error [\d.]+ mm, [\d.]+ deg", "unbalance 3 kg m"],
    "06_own_kind": [r"pd: rms error [\d.]+ mrad", r"c_axis_ramp_cutting.c c_axis_ramp_cutting.h"],
}


def test_every_example_is_run():
    assert sorted(path.stem for path in EXAMPLES.glob("*.py")) == sorted(PRINTS)


@pytest.mark.parametrize("name", PRINTS)
def test_example(name, tmp_path, monkeypatch, capsys, own_plugins, known_use):
    monkeypatch.chdir(tmp_path)
    more = ["out"] if name.startswith("01") else []
    monkeypatch.setattr(sys, "argv", [name, "2", *more])
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    printed = capsys.readouterr().out + " ".join(path.name for path in tmp_path.rglob("*"))
    for line in PRINTS[name]:
        assert re.search(line, printed), printed
    if more:
        assert {"design.json", "tables", "motion.png"} <= {p.name for p in Path("out").iterdir()}


@pytest.mark.parametrize("name", [name for name in PRINTS if not name.startswith("01")])
@pytest.mark.usefixtures("known_use")
def test_command_that_an_example_names(name, tmp_path, monkeypatch, own_plugins, no_baselines):
    monkeypatch.chdir(EXAMPLES)
    text = (EXAMPLES / f"{name}.py").read_text()
    (line,) = re.findall(r"^    hfc (design .*)$", text, re.MULTILINE)
    # Of as many as the script searches: one program serves both.
    many = re.findall(r'"search.population": (\d+)', text)
    small = ["--generations", "1", *(["--population", *many] if many else [])]
    done = CliRunner().invoke(main, [*line.split(), *small, "--out", str(tmp_path / "run")])
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize(("name", "count"), [("python", 15), ("researcher", 1)])
def test_page_with_python(name, count, tmp_path, monkeypatch, own_plugins, known_use):
    """Every block runs after the others, on a small budget, without tables that adapt.

    What the found design is asked on other machines is asked of a PD.
    """
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / f"{name}.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert len(blocks) >= count
    space = {"__name__": "page"}
    small = {"generations": "2", "population": "16", "duration_s": "0.1"}
    for block in blocks:
        text = re.sub(
            rf'({"|".join(small)})": [\d.]+', lambda hit: f'{hit[1]}": {small[hit[1]]}', block
        )
        text = text.replace("jee-koren-2004-aflc", "jee-koren-2004-flc")
        text = text.replace("(result.design, scenario,", '("pd-only", scenario,')
        exec(compile(text, f"docs/{name}.md", "exec"), space)
