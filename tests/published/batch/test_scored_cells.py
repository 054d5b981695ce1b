"""The pages of a batch that scores given designs."""

import json

from run_folders import hfc


def test_the_page_begins_with_them(scored):
    page = (scored / "report.html").read_text()
    assert page.index("Published and simulated") < page.index("Groups")
    assert "nothing is random" in page
    assert "medians\nand quartiles are rough" not in page
    assert hfc("report", scored, "--each").exit_code == 0
    for name in json.loads((scored / "batch.json").read_text())["cells"]:
        own = (scored / name / "report.html").read_text()
        assert "How it was found" not in own
        assert "hfc score given.json --scenario config.toml" in own
