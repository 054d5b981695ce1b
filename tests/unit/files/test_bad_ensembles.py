"""Motions, tolerances, objectives and constraints that cannot be: one clear line each, code 2."""

import pytest
from run_folders import hfc

PLAIN = ["c-axis-ramp", "--quiet", "--population", "4", "--generations", "1"]
TOLERANCES = ["fitness.kind=tolerances"]


def refused(*arguments):
    """The one line on stderr; nothing is on stdout."""
    done = hfc(*arguments)
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    assert done.stderr.startswith("hfc: ")
    assert done.stderr.count("\n") == 1
    return done.stderr


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            ["motions=[{name='a'},{name='b',sample_time_s=0.002}]"],
            ["c-axis-ramp: motions.1.sample_time_s: all motions have the clock of the scenario"],
        ),
        (
            ["motions=[{name='a'},{name='b',simulation={substeps=2}}]"],
            ["motions.1.simulation: all motions have the clock of the scenario"],
        ),
        (
            ["motions=[{name='a'},{name='b',duration_s=2.0,settled_after_s=3.0}]"],
            ["motions.1: settled_after_s = 3.0: has to be less than its duration of 2.0 s"],
        ),
        (["robust.spread=1"], ["robust.spread = 1: ", "less than 1"]),
        (
            ["robust.margin=1.2", "robust.spread=0.9"],
            ["robust.spread = 0.9: times margin = 1.2 it has to stay below 1"],
        ),
        (
            ["robust.margin=1.2", "robust.tolerances.stiffness=0.9"],
            ["robust.tolerances.stiffness = 0.9: times margin = 1.2 "],
        ),
        (["robust.keep=best"], ["robust.keep = 'best': ", "'worst', 'quantile' or 'mean'"]),
        (["constraints.speed=1"], ["constraints.speed: is no measure; there is rms_error, max_er"]),
        (["constraints.limit_share=-1"], ["constraints.limit_share = -1.0: has to be zero or mor"]),
        (["constraints.limit_share=nan"], ["constraints.limit_share = nan: ", "finite"]),
        (["constraints.late_error='1 kg'"], ["constraints.late_error = '1 kg': ", "in rad"]),
        (["constraints.band_time=1"], ["constraints.band_time: needs constraints.band"]),
        (["constraints.rms_contour_error=1"], ["constraints.rms_contour_error: is of a machine"]),
        (["fitness.kind=fun"], ["fitness.kind = 'fun': is no fitness", "contour, lin-lee, "]),
        (
            [*TOLERANCES, "fitness.tolerances={fast=1}"],
            ["fitness.tolerances.fast: is no measure; there is rms_error, "],
        ),
        (
            [*TOLERANCES, "fitness.tolerances={rms_error='1 kg'}"],
            ["fitness.tolerances.rms_error = '1 kg': has to be a quantity in rad"],
        ),
        (
            [*TOLERANCES, "fitness.tolerances={rms_error=0}"],
            ["fitness.tolerances.rms_error = 0.0: has to be more than zero"],
        ),
        (
            [*TOLERANCES, "fitness.tolerances={band_time=1}"],
            ["fitness.tolerances.band_time: needs fitness.band"],
        ),
    ],
)
def test_a_scenario_that_cannot_be(changes, words, tmp_path):
    options = [text for change in changes for text in ("--set", change)]
    line = refused("design", *PLAIN, "--out", tmp_path / "run", *options)
    for word in words:
        assert word in line
    assert not (tmp_path / "run").exists()


def test_an_unknown_objective_of_a_front_is_told_all_that_there_are(tmp_path):
    line = refused("design", *PLAIN, "--pareto", "tracking,fun", "--out", tmp_path / "run")
    assert "--pareto fun: is no objective; there is tracking, effort, " in line
    assert " ... " not in line
    assert not (tmp_path / "run").exists()
