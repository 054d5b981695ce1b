import phone


def test_report_in_a_browser_as_wide_as_a_phone(report, tmp_path):
    assert phone.figures_that_fit(report[1], tmp_path) == 12
