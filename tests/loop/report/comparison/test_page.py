"""The page of a comparison: nothing from outside, names are only text, curves can be zoomed."""

import json
import re
from html.parser import HTMLParser

import pytest

from hfc_design.report.comparison.page import page
from hfc_design.report.latex import table


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


def test_names_are_only_text(written):
    found = Page(written)
    kinds = [own.get("type") for own, _ in found.of("script")]
    assert kinds == ["application/json", None, None]
    for own, _ in found.of("img"):
        assert own["src"].startswith("data:image/svg+xml")
    assert not any(key.startswith("on") for _, own in found.elements for key in own)
    assert "49" not in re.findall(r"\{\{ (.*?) \}\}", written)
    assert "&lt;img src=x&gt;" in written
    data = json.loads(found.of("script")[0][1])
    assert any("<img src=x>" in name for name in data[0]["panels"][0]["names"])
    assert len(found.ids) == len(set(found.ids))
    for _, own in found.elements:
        if "aria-labelledby" in own:
            assert own["aria-labelledby"] in found.ids


def test_labels_in_latex_are_unique_over_comparisons(spindles, tables):
    """Of the same designs in other motions too, and captions name the motion once."""
    fewer = spindles._replace(bouts=spindles.bouts[:1])
    labels = []
    for comparison in (spindles, fewer, tables):
        found = page(comparison)
        texts = [table(k, own, found.of, found.label) for k, own in found.tables.items()]
        labels += [re.search(r"\\label\{(.*)\}", text)[1] for text in texts]
        for text in texts:
            caption = re.search(r"\\caption\{(.*)\}", text)[1]
            assert all(caption.count(bout.name) <= 1 for bout in comparison.bouts)
            of_designs = "the designs that are compared" in caption
            assert caption.count("machines within") == (not of_designs)
    assert len(labels) > 10
    assert len(labels) == len(set(labels))
