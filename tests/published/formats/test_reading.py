"""Controllers of other programs, read back as designs."""

import json
from pathlib import Path

from click.testing import CliRunner
from imported_files import OCTAVE, PYFUZZYLITE

from hfc_design.cli import main
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as designs
from hfc_design.simulation.evaluating import evaluate


def test_the_command_writes_a_design_that_a_search_starts_from(tmp_path, no_baselines):
    def hfc(*arguments):
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    out = tmp_path / "mine.json"
    done = hfc("import", PYFUZZYLITE, "--out", out, "--kind", "flc")
    assert done.exit_code == 0
    assumed = "plant feed-drive, sample time 0.01 s assumed: --plant, --sample-time"
    assert done.stdout == f"{assumed}\n{out}\n"
    assert "already exists" in hfc("import", OCTAVE, "--out", out).stderr
    assert "INPUT=SIGNAL" in hfc("import", OCTAVE, "--signal", "error").stderr
    assert json.loads(out.read_text())["name"] == "pyfuzzylite-8.0.6"
    scenario = tmp_path / "mine.toml"
    circle = load_scenario("feed-drive-circle").model_dump(mode="json", exclude_none=True)
    assert circle["controller"]["kind"] == "aflc"
    text = (
        Path(designs.__file__).parents[1] / "files" / "scenarios" / "feed-drive-circle.toml"
    ).read_text()
    scenario.write_text(text.replace('kind = "aflc"', 'kind = "flc"\nstart = "mine.json"'))
    small = ["--population", 8, "--generations", 2, "--set", "simulation.duration_s=4.0"]
    done = hfc("design", scenario, "--out", tmp_path / "run", "--quiet", *small)
    assert done.exit_code == 0, done.stderr
    found = load_design(str(tmp_path / "run"))
    assert found.controller.kind == "flc"
    assert evaluate(found, load_scenario(str(scenario), ["simulation.duration_s=4.0"])).fitness > 0
