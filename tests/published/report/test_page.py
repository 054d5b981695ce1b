import base64
import shutil
from html.parser import HTMLParser

from random_runs import diverged

from hfc_design.report.page import write_page


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses, self.images = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.tags.append(tag)
        self.addresses += [found[key] for key in ("src", "href", "xlink:href") if key in found]
        if tag == "img":
            self.images.append(found)


def test_report_stands_alone_and_is_small(report):
    text = report[1].read_text()
    page = Page(text)
    assert len(text) < 1_000_000
    assert page.addresses
    assert all(address.startswith("data:") for address in page.addresses)
    assert "url(" not in text
    assert "@import" not in text
    assert "link" not in page.tags
    for picture in page.images:
        drawing = base64.b64decode(picture["src"].partition(",")[2]).decode()
        assert all(address.startswith(("#", "data:")) for address in Page(drawing).addresses)
        assert picture["alt"]


def test_report_of_diverged_designs(report, tmp_path):
    (scenario, result, folder, rivals), _ = report
    shutil.copy(folder / "config.toml", tmp_path)
    lost = diverged(scenario)
    write_page(scenario, result._replace(evaluation=lost), tmp_path, {"pd-only": lost})
    text = (tmp_path / "report.html").read_text()
    assert "diverges on c-axis-ramp-cutting" in text
    assert text.count(">diverged<") == 4  # fitness and merit of two designs
    write_page(scenario, result, tmp_path, rivals | {"lin-lee-1999-table-1": lost})
    assert "Table I of Lin &amp; Lee (1999) diverges" in (tmp_path / "report.html").read_text()
