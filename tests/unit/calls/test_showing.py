"""What functions of the API return is drawn by plot, and shows itself."""

import re

from run_folders import batch_folder
from wording import refused

import hfc_design.api as hfc

AHEAD = {"velocity": 13.6, "acceleration": 28.0, "coulomb": 3.6, "coulomb_width": 0.003}
GAINS = {"kp": 1900.0, "ki": 1500.0, "kd": 450.0, "feed_forward": AHEAD}


def test_margins_of_a_linear_loop():
    """Stable is what has all poles inside the unit circle."""
    found = hfc.stability(hfc.with_gains("c-axis-ramp", "pid+ff", GAINS))
    (axis,) = found.numbers()["axes"].values()
    sizes = [abs(complex(pole["real"], pole["imaginary"])) for pole in axis["poles"]]
    assert axis["stable"] == (max(sizes) < 1.0) is True
    assert re.match(r"LoopMargins\(stable=True, gain_up=", repr(found))
    assert f"{axis['phase']:.4g}" in found._repr_html_()
    with refused():
        hfc.stability(hfc.with_gains("c-axis-ramp", "pid+ff", GAINS), gain=2.0)


def test_several_motions_are_no_single_one():
    with refused():
        hfc.robustness("pd-only", "c-axis-tolerances", 0.2, 4)


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
