"""The page of a comparison: nothing from outside, names are only text."""

import base64
import hashlib
import json
import re

import pytest
from html_page import Page

from hfc_design.report.comparison.page import page
from hfc_design.report.comparison.tables import rows


@pytest.fixture(scope="module")
def first(spindles):
    """It says how to compare again."""
    return page(spindles, "hfc compare <a> b")


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


def test_rows_of_every_machine(spindles):
    head, *found = rows(spindles)
    assert len(found) == 2 * 2 * 9
    table = [dict(zip(head, row, strict=True)) for row in found]
    first = spindles.bouts[0].results["pd-only"]
    for row, k in ((table[0], 0), (table[5], 5)):
        assert (row["design"], row["motion"]) == ("pd-only", "c-axis-ramp")
        assert row["machine"] == k
        assert row["spindle_inertia"] == first.machines.actual[0].spindle_inertia[k]
    assert table[0]["rms_error_rad"] == first.nominal["rms_error_rad"]
    assert table[5]["rms_error_rad"] == first.values["rms_error_rad"][4]
    assert table[5]["stable"] == int(first.stable[4])
