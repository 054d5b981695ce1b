"""The page of many runs, and the page of one that was run without."""

from collections import Counter
from html.parser import HTMLParser

from run_folders import HOSTILE, batch_folder, hfc


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses = Counter(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags[tag] += 1
        self.addresses += [value for key, value in attributes if key in ("src", "href")]


def test_hostile_settings_are_only_text(tmp_path):
    folder = tmp_path / "<i>"
    names = batch_folder(folder, [({"description": HOSTILE + str(k)}, [k, 9.0]) for k in (2, 3)])
    (folder / names[0] / "report.html").touch()
    assert hfc("report", folder).exit_code == 0
    text = (folder / "report.html").read_text()
    page = Page(text)
    assert page.tags["script"] == 1
    assert page.tags["i"] == 0
    assert "alert(&#34;1&#34;)" in text
    assert page.tags["figure"] == 2
    assert [address for address in page.addresses if not address.startswith("data:image/svg")] == [
        f"{names[0]}/report.html"
    ]
