"""The page of a comparison: nothing from outside, names are only text, curves can be zoomed."""

import base64
import hashlib
from html.parser import HTMLParser

import pytest

from hfc_design.report.comparison.page import page


class Page(HTMLParser):
    """Elements, attributes, and the texts of scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.texts, self.ids, self.open = [], [], [], False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.texts.append("")
        self.open = True
        self.ids += [value for key, value in attributes if key == "id"]

    def handle_endtag(self, tag):
        self.open = False

    def handle_data(self, text):
        if self.open:
            self.texts[-1] += text

    def of(self, tag):
        pairs = zip(self.elements, self.texts, strict=True)
        return [(own, text) for (name, own), text in pairs if name == tag]


@pytest.fixture(scope="module")
def written(spindles):
    return page(spindles, "hfc compare <a> b").html.decode()


def test_nothing_but_its_own_scripts_may_run(written):
    found = Page(written)
    (policy,) = (own["content"] for own, _ in found.of("meta") if "http-equiv" in own)
    assert policy.startswith("default-src 'none'; img-src data:;")
    assert "unsafe" not in policy
    ran = [text for own, text in found.of("script") if "type" not in own]
    for text in (*ran, *(text for _, text in found.of("style"))):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert not any("style" in own for _, own in found.elements)
    addresses = [x for _, own in found.elements for x in (own.get("src"), own.get("href")) if x]
    assert all(address.startswith("data:image/svg+xml") for address in addresses)
    assert "Permission is hereby granted" in written  # the licence of what is in it
