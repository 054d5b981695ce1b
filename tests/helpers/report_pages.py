"""Pages of a run and of a lone design, small ones: two programs of 512 samples for all of them.

What a design does on other machines is not simulated for them: ``USED`` tells it.
"""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from random_runs import HOSTILE, finished

from hfc_design.cli import main
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, design_json
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.report import page, parts
from hfc_design.runs.run import Result, new_run
from hfc_design.simulation.evaluating import evaluate

NAME, FILE = "lin-lee-1999-table-1", "<b>&'.json"
SHORT = "simulation.duration_s=0.5"
#: The scenario of the lone design: another one than its own, with a description that does harm.
SINE = "--scenario", "c-axis-sine", "--set", SHORT, "--set", f"description={json.dumps(HOSTILE)}"


def told(share, reasons, scale=1.0):
    """What ``hfc score --usable`` tells of a motion."""
    values = {"settled_rms_error": 3.57e-6, "chatter": 3.79, "peak_command": 120.0}
    measures = {
        key: {"nominal": x, "median": scale * x, "q95": x, "largest": 1000 * scale * x}
        for key, x in values.items()
    }
    own = {"share": share, "reasons": reasons, "nominal": [], "asked_of": "all"}
    return own | {"measures": measures | {"limit_share": {"median": 0.0, "largest": 0.381}}}


REASONS = {"is far off": 1, "oscillates": 2, "exceeds unsettled": 2, "stays at a limit": 1}
USED = {
    "usable": False,
    "verdict": "no",
    "answer": "no: only 99.6 % of 1000 unseen machines within +-15 % pass",
    "spread": 0.15,
    "machines": 1000,
    "seed": 2**32,
    "missed": {},
    "stress": [],
    "share": 0.996,
    "interval": [0.9898, 0.9989],
    "gain": [0.455, 16.0],
    "precision": 0.0027,
    "substeps": None,
    "units": {"settled_rms_error": "rad", "chatter": "V", "peak_command": "V"},
    "motions": {
        "ramp": told(1.0, {}) | {"asked_of": "nominal"},
        "position": told(0.998, REASONS, 2.0),
    },
}


def write(*arguments, answer=USED):
    """``write_page`` of a run of which it is known whether its design can be used."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "used", lambda *_: json.loads(json.dumps(answer)))
        page.write_page(*arguments)


def run_page(folder):
    """The arguments of ``write``, and its page, of Table I with its rules turned over."""
    changes = (SHORT, f"description={json.dumps(HOSTILE)}")
    scenario = new_run(load_scenario("c-axis-ramp-cutting", changes), folder)
    record = json.loads(design_json(load_design(NAME)))
    for unit in record["controller"]["units"]:
        unit["consequents"] = [[-0.1 * x for x in row] for row in unit["consequents"]]
    record["provenance"]["note"] = HOSTILE
    found = Design.model_validate(record)
    rivals = {name: evaluate(load_design(name), scenario) for name in (NAME, "pd-only")}
    arguments = scenario, Result(found, evaluate(found, scenario), finished(5)), folder, rivals
    write(*arguments)
    return arguments, folder / "report.html"


def lost(evaluation):
    """The evaluation as if its only axis ran away after 100 samples, and ended nowhere."""
    (axis,) = evaluation.axes
    gone = np.append(10.0 ** np.arange(50), np.full(len(evaluation.time) - 150, np.nan))

    def running(values):
        return np.append(values[:100], gone)

    motion = axis.motion
    state = type(motion.state)(*map(running, motion.state))
    parts = {"error": running(motion.error), "command": running(motion.command), "state": state}
    axes = (axis._replace(motion=motion._replace(**parts)),)
    none = {"fitness": -np.inf, "merit": -np.inf, "diverged": True, "divergence": "it runs away"}
    return evaluation._replace(axes=axes, **none)


def unknown(*_):
    """In the place of ``usable`` where nobody asks."""
    raise UserError("nobody asks")


def lone_page(folder):
    """What ``hfc report`` of a design file of a hostile name writes, also for a paper."""
    (folder / FILE).write_text(design_json(load_design(NAME)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "usable", unknown)
        patch.delitem(parts.BASELINES, "c-axis")
        command = ["report", str(folder / FILE), *SINE, "--out", str(folder / "mine.html")]
        command += ["--figures", "svg", "--width", "8cm", "--latex"]
        done = CliRunner().invoke(main, command)
    assert done.exit_code == 0, done.output
    assert done.stdout.splitlines()[0] == str(folder / "mine.html")
    return folder / "mine.html"
