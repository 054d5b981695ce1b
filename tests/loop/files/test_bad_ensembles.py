"""Motions, tolerances, objectives and constraints that cannot be: one clear line each, code 2."""

from run_folders import hfc


def refused(*arguments):
    """The one line on stderr; nothing is on stdout."""
    done = hfc(*arguments)
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    assert done.stderr.startswith("hfc: ")
    assert done.stderr.count("\n") == 1
    return done.stderr


def test_a_scenario_that_does_not_fit_is_refused_before_the_first_one_is_simulated():
    given = ["--scenario", "c-axis-ramp", "--scenario", "feed-drive-circle"]
    line = refused("score", "pd-only", *given)
    assert "design pd-only is for the plant c-axis, scenario feed-drive-circle has feed" in line
    slow = ["--scenario", "c-axis-practical", "--set", "simulation.sample_time_s=0.002"]
    assert "design pd-only runs every 0.001 s, scenario c-axis-practical has " in refused(
        "score", "pd-only", *slow
    )
