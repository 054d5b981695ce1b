"""What functions of the API return is drawn by plot, and shows itself."""

from run_folders import batch_folder

import hfc_design.api as hfc


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
