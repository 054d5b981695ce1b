"""The report of a run that designs a feed drive's fuzzy controller, and its pictures."""

import phone
import pytest
from fuzzy_report import reported


@pytest.fixture(scope="module", params=["flc", "aflc"])
def report(request, tmp_path_factory):
    return reported(request.param, tmp_path_factory.mktemp(request.param) / "run")


def test_page_in_a_browser_as_wide_as_a_phone(report, tmp_path):
    (_, result, folder, _), _ = report
    drawn = phone.figures_that_fit(folder / "report.html", tmp_path)
    assert drawn == (13 if result.design.controller.kind == "aflc" else 7)
