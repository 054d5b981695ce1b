"""``hfc init``: what it writes loads, runs and explains every key."""

import re

import pytest
from run_folders import hfc

from hfc_design.files.named_scenario import load_scenario


def test_all_defaults_at_once_change_nothing(tmp_path):
    """Every commented key that holds by default is what it says."""
    file = tmp_path / "mine.toml"
    hfc("init", "--out", file)
    before = load_scenario(str(file)).model_dump(exclude={"plant"})
    text = file.read_text().partition("#[[windows]]")[0]
    for table in ("plant", "simulation", "limits", "sensors", "search", "run"):
        head, found, rest = text.partition(f"\n[{table}]\n")
        own, mark, after = rest.partition("\n\n")
        own = re.sub(r"^#(\w+ = (?!NUMBER|\"TEXT|\.\.\.))", r"\1", own, flags=re.MULTILINE)
        text = head + found + own + mark + after
    file.write_text(text)
    assert text.count("\nsubsteps = 1") == 1
    assert load_scenario(str(file)).model_dump(exclude={"plant"}) == before


def test_every_key_has_a_meaning_before_it(tmp_path):
    file = tmp_path / "mine.toml"
    hfc("init", "--out", file)
    lines = file.read_text().splitlines()
    keys = [k for k, line in enumerate(lines) if re.match(r"#?\w+ = ", line)]
    assert len(keys) > 80
    inside = [k for k in keys if lines[k].startswith(("rms_error", "settled_rms_error"))]
    assert [lines[k] for k in keys if k not in inside and not lines[k - 1].startswith("# ")] == []
    assert max(map(len, lines)) <= 120


@pytest.mark.parametrize("kind", ["pid", "pid+ff", "lqr"])
def test_other_controllers(kind, tmp_path):
    file = tmp_path / "mine.toml"
    done = hfc("init", "--plant", "positioning-stage", "--controller", kind, "--out", file)
    assert done.exit_code == 0, done.output
    assert load_scenario(str(file)).controller.kind == kind
