"""Links, commands and blocks of the pages lead somewhere, and no page is a wall of text."""

import ast
import hashlib
import json
import re
import shlex
import tomllib
from pathlib import Path

import click
import doc_pages
import pytest
from doc_pages import NOTEBOOKS, PAGES, ROOT, stored, texts

from hfc_design.cli import main

EVERY = pytest.mark.parametrize("page", PAGES, ids=doc_pages.name)
#: Lines of text in three screens of a site, of 105 letters as the pages have; tables come beside.
THREE_SCREENS = 105
#: SHA-256 of shim/index.js in the npm release 1.0.4 of iframe-worker.
SHIM = "e8e412dbcfea9b7e31b5ffa288d7b6035915e714c542f4176a0cdbe262fc9609"
#: A list of changes is no page to read.
LISTS = ("CHANGELOG.md",)


@EVERY
def test_links_lead_somewhere(page):
    for file, anchor in doc_pages.links(page):
        assert file.exists(), f"{file} of {page}"
        if anchor:
            assert anchor in doc_pages.anchors(file), f"{file}#{anchor} of {page}"


@EVERY
def test_blocks_are_of_their_language(page):
    for text in doc_pages.blocks(page, "toml"):
        tomllib.loads(text)
    for text in doc_pages.blocks(page, "json"):
        json.loads(text if text.startswith("{") else f"{{{text}}}")  # or keys out of a file
    for text in doc_pages.blocks(page, "python"):
        ast.parse(text)


@EVERY
def test_commands_have_the_options_that_they_are_given(page):
    for line in doc_pages.commands(page):
        words = shlex.split(line, comments=True)[1:]
        words = words[: words.index(">")] if ">" in words else words
        if words[0].startswith("-"):
            continue
        command = main.commands[words[0]]
        with click.Context(main, info_name="hfc", **main.context_settings) as parent:
            context = command.make_context(words[0], words[1:], parent, resilient_parsing=True)
        left = [word for word in context.args if word.startswith("-")]
        assert not left, line


@EVERY
def test_three_screens_have_a_picture_or_an_example(page):
    if doc_pages.name(page) in LISTS:
        return
    text = page.read_text("utf-8")
    marked = doc_pages.BLOCK.sub("![]()\n", text)
    parts = re.split(r"^!\[.*$", marked, flags=re.MULTILINE)
    texts = [[x for x in part.splitlines() if not x.startswith("|")] for part in parts]
    longest = max(sum(-(-len(line) // 105) or 1 for line in text) for text in texts)
    assert longest <= THREE_SCREENS


def test_every_page_has_its_place_in_the_site():
    nav = (ROOT / "docs" / "site" / "mkdocs.yml").read_text("utf-8").partition("\nnav:")[2]
    placed = re.findall(r"(\S+\.md)$", nav, re.MULTILINE)
    assert len(placed) == len(set(placed))
    written = {one for one in placed if not one.startswith("docs/reference/")}
    books = (ROOT / "docs" / "notebooks").glob("*.ipynb")
    pages = [*PAGES, *(book.with_suffix(".md") for book in books)]
    assert written == {doc_pages.name(page) for page in pages}


def test_pictures_are_small():
    pictures = [*(ROOT / "docs" / "pictures").iterdir()]
    assert len(pictures) >= 7
    for picture in pictures:
        assert picture.stat().st_size < 150_000, picture


def test_what_searches_from_the_disk_is_that_of_the_release():
    folder = ROOT / "docs" / "site" / "iframe-worker"
    shim = (folder / "shim.js").read_bytes()
    assert hashlib.sha256(shim).hexdigest() == SHIM
    assert "Permission is hereby granted" in (folder / "LICENSE").read_text("utf-8")


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_cell_was_run_in_order_and_is_small(path):
    code = [cell for cell in stored(path)["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in code] == [*range(1, len(code) + 1)]
    kinds = {one["output_type"] for cell in code for one in cell["outputs"]}
    assert kinds == {"stream", "execute_result"}
    streams = {one.get("name") for cell in code for one in cell["outputs"]}
    assert "stderr" not in streams
    text = path.read_text("utf-8")
    assert len(text) < 190_000
    assert str(Path.home()) not in text


def test_what_varies_is_seldom():
    """Else nothing would be compared."""
    for path in NOTEBOOKS:
        assert sum(map(len, texts(stored(path)))) > 150, path


def test_the_words_are_in_alphabetical_order():
    rows = (
        (ROOT / "docs" / "concepts.md").read_text().partition("| word | meaning |\n|---|---|\n")[2]
    )
    words = [row.split(" | ")[0].strip("| *").lower() for row in rows.splitlines()]
    assert words == sorted(words)
    assert {"blu", "chatter", "margin", "observer", "settled"} <= {*words}
