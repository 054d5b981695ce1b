"""The site of ``make docs`` as a browser has it from the disk; make it first."""

import re
import shutil
import subprocess

import pytest
from doc_pages import ROOT

from hfc_design import api

SITE = ROOT / "build" / "site"
pytestmark = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="make docs has not run")
OPTIONS = (
    "--headless --no-sandbox --disable-gpu --disable-background-networking --no-first-run "
    "--enable-logging=stderr --v=0 --allow-file-access-from-files --virtual-time-budget=15000"
)


def shown(address, folder):
    """The DOM of a page after its scripts, and what its console said."""
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no chromium on the PATH")
    command = [chromium, *OPTIONS.split(), f"--user-data-dir={folder}/profile", "--dump-dom"]
    done = subprocess.run(
        [*command, address], capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def test_every_public_object_is_documented():
    page = (SITE / "docs" / "reference" / "python-api.html").read_text("utf-8")
    shown_there = set(re.findall(r'id="hfc_design\.api\.(\w+)"', page))
    assert set(api.__all__) <= shown_there


def test_nothing_is_fetched():
    for page in SITE.rglob("*.html"):
        text = page.read_text("utf-8")
        loaded = re.findall(r'<(?:script|img|iframe)[^>]*\ssrc="?([^"\s>]*)', text)
        loaded += re.findall(r'<link[^>]*rel="?stylesheet"?[^>]*href="?([^"\s>]*)', text)
        loaded += re.findall(r'<link[^>]*href="?([^"\s>]*)[^>]*rel="?stylesheet', text)
        assert loaded
        assert not [one for one in loaded if "//" in one], page


def test_lists_and_tables_are_drawn_as_such():
    """The dialect of code hosts needs no empty line before a list, that of the site does."""
    for page in SITE.rglob("*.html"):
        text = re.sub(r"(?s)<pre.*?</pre>", "", page.read_text("utf-8"))
        for part in re.findall(r"(?s)<p>(.*?)</p>", text):
            assert not re.search(r"(?m)^(\s*[-*] |\| |\d\. )", part), f"{page}: {part[:80]}"


def test_it_searches_from_the_disk(tmp_path):
    dom, said = shown((SITE / "docs" / "start.html").as_uri() + "?q=backlash", tmp_path)
    assert said == []
    found = re.findall(r'class="md-search-result__link"[^>]*href="([^"]*)"', dom)
    found += re.findall(r'href="([^"]*)"[^>]*class="md-search-result__link"', dom)
    assert any("milling-table.html" in one for one in found)
