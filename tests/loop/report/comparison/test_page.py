"""The page of a comparison: nothing from outside, names are only text."""

import base64
import hashlib
import json
import re

import pytest
from html_page import Page

from hfc_design.pictures.latex import table
from hfc_design.report.comparison.page import page


@pytest.fixture(scope="module")
def first(spindles):
    """It says how to compare again."""
    return page(spindles, "hfc compare <a> b")


@pytest.fixture(scope="module")
def second(tables):
    return page(tables)


@pytest.fixture
def written(first):
    return first.html.decode()


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
    assert all(address.startswith("data:image/svg+xml") for address in found.addresses)
    assert "Permission is hereby granted" in written  # the licence of what is in it


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


def test_the_same_comparison_gives_the_same_bytes(spindles, written):
    assert page(spindles, "hfc compare <a> b").html.decode() == written


def test_it_is_small_and_says_what_is_compared(second, written):
    assert len(written) < 450_000
    assert "8 others" in written.replace("\n", " ")
    assert "<code>hfc compare &lt;a&gt; b</code>" in written
    other = second.html.decode()
    assert other.count("times enlarged") == 2
    assert "To reproduce:" not in other


def test_labels_in_latex_are_unique_over_comparisons(first, second, spindles, tables):
    """Of the same designs in other motions too, and captions name the motion once."""
    fewer = spindles._replace(bouts=spindles.bouts[:1])
    labels = []
    each = (first, second, page(fewer))
    for comparison, found in zip((spindles, tables, fewer), each, strict=True):
        texts = [table(k, own, found.of, found.label) for k, own in found.tables.items()]
        labels += [re.search(r"\\label\{(.*)\}", text)[1] for text in texts]
        for text in texts:
            caption = re.search(r"\\caption\{(.*)\}", text)[1]
            assert all(caption.count(bout.name) <= 1 for bout in comparison.bouts)
            of_designs = "the compared designs" in caption
            assert caption.count("machines within") == (not of_designs)
    assert len(labels) > 10
    assert len(labels) == len(set(labels))
