"""Whatever the files and texts of a user hold: a record, or one line that says what is wrong.

Millions of damaged files go through every reader. What a reader takes is compared with what
other programs make of it, or with itself after being written.
"""

import csv
import io
import json
import math
import random
import tomllib

import mutants
import numpy as np
import pytest
from attack import FULL, SEED, Attack, rounds
from mutants import mutant

from hfc_design.batch import folder
from hfc_design.batch.plan import read_batch
from hfc_design.batch.results import runs_below
from hfc_design.core import plugins
from hfc_design.core.overrides import set_keys
from hfc_design.core.records import LONGEST, UserError
from hfc_design.core.validation_errors import MOST
from hfc_design.files.design import design_json, parse_design, read_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.machine import PlantSettings
from hfc_design.files.named_scenario import load_scenario, scenario_toml
from hfc_design.files.scenario import MAX_STEPS
from hfc_design.formats import FORMATS
from hfc_design.formats.reading import Wish, imported
from hfc_design.motion import gcode
from hfc_design.motion.paths import Path
from hfc_design.motion.references import table_of
from hfc_design.runtime.explain import explanation
from hfc_design.simulation.closed_loop import closed_loop  # noqa: F401 - JAX, before any input


def scenario(place, text):
    file = place / "mine.toml"
    file.write_bytes(text)
    found = load_scenario(file)
    again = place / "again.toml"
    again.write_text(scenario_toml(found), encoding="utf-8")
    assert load_scenario(again) == found
    assert found.name == tomllib.loads(file.read_text("utf-8")).get("name", "mine")
    assert 1 <= found.simulation.steps <= MAX_STEPS
    if found.follows_path:
        assert math.isfinite(found.reference.duration_s)


def batch(place, text):
    file = place / "mine.toml"
    file.write_bytes(text)
    plan = read_batch(file)
    assert len({cell.name for cell in plan.cells}) == len(plan.cells) > 0


def design(place, text):
    file = place / "mine.json"
    file.write_bytes(text)
    found = read_design(file)
    written = design_json(found)
    assert parse_design(written, "again") == found
    told = json.loads(text)
    assert json.loads(written)["provenance"] == told.get("provenance", {})
    assert found.name == told["name"]


def plan(place, text):
    (place / "batch.json").write_bytes(text)
    found = [told.description for told in folder.batch_notes(place)]
    assert found == [x.get("description", "") for x in json.loads(text).get("files", {}).values()]


def table(place, text):
    """A load that a scenario names, beside Python's own reader of CSV and of numbers."""
    (place / "load.csv").write_bytes(text)
    found = load_scenario({"load": {"file": str(place / "load.csv")}})
    assert np.isfinite(found.load.at(np.array([0.0]))).all()
    lines = text.decode("utf-8-sig").splitlines()
    rows = [[float(x) for x in r] for r in csv.reader(_plain(lines)) if r]
    times, values = table_of(found.load.file)
    assert [[*pair] for pair in zip(times, values, strict=True)] == rows


def _plain(lines):
    """Without a header and without what follows a #, as numpy takes them."""
    for k, line in enumerate(lines):
        told = line.partition("#")[0]
        if not (k == 0 and not told.lstrip().lstrip("+-.")[:1].isdecimal()) and told.strip():
            yield told


def program(place, text):
    """Each segment of a path begins where the one before has ended."""
    file = place / "mine.ngc"
    file.write_bytes(text)
    path = Path.of(gcode.read(file, 1500.0))
    assert all(np.isfinite(part).all() for part in path)
    assert min(path.length.min(), path.feed.min()) > 0
    last = np.arange(len(path.length))
    ends = path.on(last, path.length).position
    assert np.abs(ends[:, :-1] - path.start[:, 1:]).max(initial=0.0) < 1e-6
    assert np.abs(np.hypot(*path.tangent) - 1.0).max() < 1e-9


def fll(place, text):
    fuzzy(place, text, ".fll")


def fis(place, text):
    fuzzy(place, text, ".fis")


def fuzzy(place, text, suffix):
    """What is imported, and exported for the same program, is imported as the same."""
    file = place / f"mine{suffix}"
    file.write_bytes(text)
    wish = Wish(signals={})
    try:
        found = imported(file, wish)
    except UserError as error:
        if "signals=" not in str(error):
            raise
        found = imported(file, Wish(signals={"change": "error_change"}))
    assert parse_design(design_json(found), "again") == found
    if found.controller.kind == "flc":
        units = FORMATS["csv"].content(found)
        for name, content in units.items():
            (place / name).write_text(content)
        again = imported(place / "rules.csv", wish)
        assert again.controller.rules == found.controller.rules
        assert again.controller.error_terms == found.controller.error_terms


TABLES = FORMATS["csv"].content(load_design("jee-koren-2004-flc"))
NAMES = ("rules.csv", "error_terms.csv", "error_change_terms.csv")


def tables(place, text):
    """One of the tables of a folder; the others are whole."""
    for name in NAMES:
        (place / name).write_text(TABLES[name])
    first = text.partition(b"\n")[0]
    name = NAMES[0] if not first.startswith(b"label") else NAMES[1 + (b"-" in text[:99])]
    (place / name).write_bytes(text)
    found = imported(place, Wish(name="mine"))
    assert parse_design(design_json(found), "again") == found
    rows = list(csv.reader(io.StringIO((place / NAMES[0]).read_text(encoding="utf-8"))))
    cells = sorted(float(cell) for row in rows[1:] for cell in row[1:] if any(row))
    assert cells == sorted(x for row in found.controller.rules.centroids for x in row)


def setting(place, text):
    told = text.decode(errors="surrogateescape")
    found = load_scenario("c-axis-ramp", [told])
    key, _, value = told.partition("=")
    if key.strip() == "description":
        assert found.description in (value.strip(), *_toml(value))
    (place / "set.toml").write_text(scenario_toml(found), encoding="utf-8")
    assert load_scenario(place / "set.toml") == found


def _toml(value):
    try:
        return [tomllib.loads(f"x = {value}")["x"]]
    except (ValueError, RecursionError):
        return []


def change(place, text):
    told = text.decode(errors="surrogateescape")
    found = load_design("jee-koren-2004-flc", [told])
    assert parse_design(design_json(found), "again") == found
    assert set_keys([told], "change").keys() == {told.partition("=")[0].strip()}


FLC = load_design("jee-koren-2004-flc")
AXIS = PlantSettings(**FLC.plant.model_dump()).each()[0]


def sample(place, text):
    told = text.decode(errors="surrogateescape")
    found = explanation(FLC, AXIS.drive, AXIS.parameters, [told])
    given = dict(item.split("=") for item in told.split(","))
    assert found["signals"] == {key.strip(): float(value) for key, value in given.items()}


def own_part(place, text):
    plugins.use(text.decode(errors="surrogateescape"))


def run_folder(place, text, name):
    run = place / "a"
    run.mkdir(exist_ok=True)
    whole = {"config.toml": mutants.CONFIG[0], "history.csv": mutants.HISTORY[0]}
    whole["design.json"] = json.dumps({"score": {"fitness": 1.0, "merit": 2.0}}).encode()
    for file, content in (whole | {name: text}).items():
        (run / file).write_bytes(content)
    (found,) = runs_below(place)
    assert found.state in ("finished", "unreadable")
    assert len(found.reason) <= 2 * LONGEST
    assert found.reason.isprintable()
    if found.reason:
        raise UserError(found.reason)


def config(place, text):
    run_folder(place, text, "config.toml")


def history(place, text):
    run_folder(place, text, "history.csv")


SCORE = [b'{"score": {"scenario": "a", "fitness": 1.5, "merit": null, "judged_by": "x", "r": 2}}']


def score(place, text):
    run_folder(place, text, "design.json")


#: Reader -> files that it takes, inputs of the full attack, longest repetition of a block.
READERS = {
    scenario: (mutants.TOML, 30_000, 4000),
    batch: (mutants.BATCH, 8_000, 200),
    design: (mutants.JSON, 150_000, mutants.LONGEST),
    plan: (mutants.PLAN, 150_000, mutants.LONGEST),
    table: (mutants.CSV, 70_000, mutants.LONGEST),
    program: (mutants.GCODE, 30_000, 8000),
    fll: (mutants.FLL, 40_000, mutants.LONGEST),
    fis: (mutants.FIS, 40_000, mutants.LONGEST),
    tables: ([TABLES[name].encode() for name in NAMES], 20_000, mutants.LONGEST),
    setting: (mutants.SET, 60_000, 4000),
    change: (mutants.OTHER, 25_000, 4000),
    sample: (mutants.AT, 170_000, mutants.LONGEST),
    own_part: (mutants.OBJECT, 120_000, 4000),
    config: (mutants.CONFIG, 40_000, mutants.LONGEST),
    history: (mutants.HISTORY, 20_000, mutants.LONGEST),
    score: (SCORE, 27_000, mutants.LONGEST),
}


def outcome(read, place, text):
    try:
        read(place, text)
    except UserError as error:
        lines = str(error).splitlines()
        assert 1 <= len(lines) <= MOST + 2  # what is missing first, how many more last
        for line in lines:
            assert 0 < len(line) <= LONGEST, line
            assert line.isprintable(), line
        assert error.exit_code == UserError.exit_code == 2
        return "refused"
    return "accepted"


@pytest.mark.parametrize("read", READERS, ids=lambda read: read.__name__)
def test_every_text_is_read_or_refused_in_a_line(tmp_path, monkeypatch, read):
    seeds, full, blocks = READERS[read]
    rng, attack = random.Random(f"{SEED} {read.__name__}"), Attack(f"readers: {read.__name__}")
    (tmp_path / "feed-drive-contour.ngc").write_bytes(mutants.GCODE[0])
    monkeypatch.chdir(tmp_path)  # where modules are looked for
    for seed in seeds:
        if read not in (own_part, table):
            attack.input(outcome, read, tmp_path, seed)
    for _ in range(rounds(60, full)):
        text = mutant(rng, seeds, blocks)
        try:
            attack.input(outcome, read, tmp_path, text)
        except Exception as error:
            (tmp_path / "found.bin").write_bytes(text)
            error.add_note(f"{read.__name__}: {text[:400]!r} ({tmp_path / 'found.bin'})")
            raise
    assert {"accepted", "refused"} & attack.outcomes.keys()
    attack.end(full=FULL)
