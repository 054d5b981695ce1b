"""The report of a run that designs a feed drive's fuzzy controller, and its pictures."""

import phone
from fuzzy_report import reported


def test_page_in_a_browser_as_wide_as_a_phone(tmp_path):
    """Of an aflc, which has all that an flc has; the rival shares its program."""
    reported("aflc", tmp_path / "run", "jee-koren-2004-aflc")
    assert phone.figures_that_fit(tmp_path / "run" / "report.html", tmp_path) == 14
