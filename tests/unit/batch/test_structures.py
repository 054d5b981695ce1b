"""Which structures won over the seeds: a made-up batch, counted by hand."""

import json

import pytest
from run_folders import batch_folder, hfc, reported, table, with_score

from hfc_design.controllers.kinds import KINDS
from hfc_design.files.design import design_json
from hfc_design.files.loop_setup import load_design

#: The trees of Tables I and II, as LL sections 4.1 and 4.2 tell them in words.
ONE = "((((spindle velocity, previous spindle velocity), deflection), error), deflection rate)"
TWO = "(((error, previous spindle velocity), deflection), (spindle velocity, deflection rate))"
TABLE_1 = "lin-lee-1999-table-1"
DESIGNS = {ONE: TABLE_1, TWO: "lin-lee-1999-table-2", "": "pd-only"}
RACE = [(10.0, ONE), (14.0, TWO), (11.0, ONE), (13.0, TWO), (12.0, ONE)]
#: 95 % Clopper-Pearson intervals as tables print them.
PRINTED = {(3, 5): (0.147, 0.947), (2, 5): (0.053, 0.853), (1, 2): (0.013, 0.987)}


def made(folder, fitness, structure):
    """Let the run in a folder have ended with a design of a structure."""
    design = json.loads(design_json(load_design(DESIGNS[structure])))
    score = json.loads((folder / "design.json").read_text())["score"]
    (folder / "design.json").write_text(json.dumps(design | {"score": score}))
    assert score["fitness"] == fitness


def batch_of(out, *groups):
    """A batch of searches: (settings, (fitness, structure) of each seed) of each group."""
    names = iter(batch_folder(out, [(own, [x for x, _ in runs]) for own, runs in groups]))
    for _, runs in groups:
        for fitness, structure in runs:
            made(out / next(names), fitness, structure)


@pytest.fixture
def counted(tmp_path):
    """Of one task a group with two structures, and one without any."""
    one, other = {"search.preset": "race"}, {"search.preset": "other"}
    batch_of(tmp_path, (one, RACE), (other, [(1.0, ""), (2.0, "")]))
    return tmp_path


def test_counts_by_hand(counted):
    reported(counted)
    first, second = table(counted / "structures.csv")
    keys = ("group", "structure", "runs", "searches")
    assert [first[key] for key in keys] == ["1", ONE, "3", "5"]
    assert [second[key] for key in keys] == ["1", TWO, "2", "5"]
    assert [float(first[key]) for key in ("share", "best", "median")] == [0.6, 12.0, 11.0]
    assert [float(second[key]) for key in ("share", "best", "median")] == [0.4, 14.0, 13.5]
    assert first["best_run"] == "0000000000000004"  # the fifth has 12
    for row in (first, second):
        found = float(row["share_low"]), float(row["share_high"])
        assert found == pytest.approx(PRINTED[int(row["runs"]), 5], abs=6e-4)


def test_who_does_not_count(tmp_path):
    """A given design, a repeated seed, a damaged controller; one that diverged does, as such."""
    batch_of(tmp_path, ({"scenario": "a"}, [(3.0, ONE), (9.0, TWO), (8.0, TWO), (0.0, TWO)]))
    given, damaged, diverged = (tmp_path / f"{k:016x}" for k in (1, 2, 3))
    (given / "given.json").write_text("{}")
    with_score(diverged, fitness=None)
    data = json.loads((damaged / "design.json").read_text())
    data["controller"]["units"][0]["row_input"] = "no such signal"
    (damaged / "design.json").write_text(json.dumps(data))
    plan = json.loads((tmp_path / "batch.json").read_text())
    plan["cells"]["0123456789abcdef"] = plan["cells"][f"{0:016x}"]
    (tmp_path / "batch.json").write_text(json.dumps(plan))
    (tmp_path / "0123456789abcdef").symlink_to(tmp_path / f"{0:016x}")
    assert hfc("report", tmp_path).exit_code == 0
    rows = table(tmp_path / "structures.csv")
    assert [(row["structure"], row["runs"], row["searches"]) for row in rows] == [
        (ONE, "1", "2"),
        (TWO, "1", "2"),
    ]
    assert [row["best"] for row in rows] == ["3.0", "-inf"]
    assert float(rows[0]["share_low"]) == pytest.approx(PRINTED[1, 2][0], abs=6e-4)


def test_a_structure_of_each_axis_and_one_inside():
    first, second = (load_design(name).controller.model_dump() for name in (TABLE_1, "pd-only"))
    axes = {"kind": "per-axis", "sample_time_s": 0.001, "axes": {"x": first, "y": second}}
    record = KINDS.get("per-axis").record.model_validate(axes)
    assert KINDS.get("per-axis").structure(record) == f"x: {ONE}, y: pd"
    inner = {key: value for key, value in first.items() if key != "sample_time_s"}
    around = load_design("huang-cross-coupled").controller.model_dump()
    assert KINDS.get("cross-coupled").structure(load_design("huang-cross-coupled").controller) == ""
    record = KINDS.get("cross-coupled").record.model_validate(around | {"inner": inner})
    assert KINDS.get("cross-coupled").structure(record) == ONE
