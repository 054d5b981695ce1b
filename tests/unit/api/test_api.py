"""The one import of scripts: names are taken wherever records are, and refused in one line."""

import numpy as np
import pytest
from run_folders import batch_folder
from wording import refused

import hfc_design.api as hfc

SHORT = {"simulation.duration_s": 0.1}
FOUND = hfc.load_design("pd-only")
RAMP = hfc.load_scenario("c-axis-ramp", SHORT)


#: What is neither a record nor the name of one, and what no argument can be.
CALLS = [
    lambda: hfc.evaluate(3, RAMP),
    lambda: hfc.evaluate(FOUND, FOUND),
    lambda: hfc.evaluate_many([FOUND, None], RAMP),
    lambda: hfc.design(None),
    lambda: hfc.Controller(3.0),
    lambda: hfc.export({}, "json", "x"),
    lambda: hfc.load_scenario(RAMP, 5),
    lambda: hfc.design("c-axis-ramp", 5),
    lambda: hfc.pick(5),
    lambda: hfc.compare([FOUND, 5]),
    lambda: hfc.evaluate_many(FOUND, RAMP, [5]),
    lambda: hfc.learned_in(FOUND, RAMP, "x"),
    lambda: hfc.trajectory_csv("pd-only"),
    lambda: hfc.comparison_page("pd-only", "a.html"),
    lambda: hfc.with_gains(RAMP, "pd", 5),
    lambda: hfc.with_gains(RAMP, "pid+ff", {"kp": 1, "signals": {"speed": 2}}),
    lambda: hfc.explain("jee-koren-2004-flc", 3),
    lambda: hfc.export(FOUND, ["c"], "a"),
    lambda: hfc.export(FOUND, "json", 5),
    lambda: hfc.Scenario(name="x", plnt={}),
    lambda: hfc.evaluate(hfc.Taught(FOUND, 0, 0, "V"), RAMP),
]


@pytest.mark.parametrize("call", CALLS)
def test_what_is_neither_is_refused_in_a_line(call):
    with refused() as found:
        call()
    assert "\n" not in found.refusal
    assert "--" not in found.refusal


def test_a_way_to_judge_many_that_there_is_not():
    judged = hfc.Judgements(np.arange(6.0).reshape(1, 2, 3), None, None)
    assert judged.kept("mean") == 2.5
    assert judged.kept("worst") == 0.0
    assert judged.kept("quantile", 0.5) == 2.0
    with refused():
        judged.kept("nonsense")


def test_only_public_names_are_listed():
    assert dir(hfc) == sorted(hfc.__all__)
    assert len(hfc.__all__) == len({*hfc.__all__})
    assert not [name for name in hfc.__all__ if not hasattr(hfc, name)]


def test_findings_are_drawn_as_their_searches(tmp_path):
    batch_folder(tmp_path, [({"search.preset": name}, [k, 9.0]) for k, name in enumerate("ab", 2)])
    found = hfc.findings(tmp_path)
    figure = hfc.plot(found)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["1: preset b", "2: preset a"]
    assert figure.axes[0].lines[1].get_ydata()[-1] == 5.5  # the median of 2 and 9
    twice = hfc.plot({"mine": found, "yours": found})
    assert len(twice.axes[0].lines) == 4
    assert twice.legends[0].get_texts()[0].get_text() == "mine 1: preset b"
