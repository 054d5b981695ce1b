"""The pages of the documentation, as a code host shows them."""

import json
import re

from places import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
PATTERNS = ("*.md", "docs/*.md", "docs/notebooks/*.md", "experiments/**/*.md", "benchmarks/*.md")
PAGES = sorted(page for pattern in PATTERNS for page in ROOT.glob(pattern))
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def name(page):
    """Where a page lies."""
    return page.relative_to(ROOT).as_posix()


def blocks(page, language):
    """The fenced blocks of a page in a language."""
    return [text for kind, text in BLOCK.findall(page.read_text("utf-8")) if kind == language]


def links(page):
    """(file, anchor) of every link and picture of a page that leads into this tree."""
    text = BLOCK.sub("", page.read_text("utf-8"))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "//" not in target:
            file, _, anchor = target.partition("#")
            yield (page.parent / file if file else page), anchor


def anchors(page):
    """What a code host calls the headings of a page."""
    text = BLOCK.sub("", page.read_text("utf-8"))
    heads = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    heads = [re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", head) for head in heads]
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def commands(page):
    """Words of every ``hfc`` line of the shell blocks of a page, without what follows a #."""
    for text in blocks(page, "sh"):
        for line in text.replace("\\\n", " ").splitlines():
            if line.startswith("hfc "):
                yield line


def texts(book):
    """Of every cell whose numbers do not hang on a search, what it prints and what it is."""
    for cell in book["cells"]:
        if cell["cell_type"] == "code" and "varies" not in cell["metadata"].get("tags", []):
            outputs = [one for one in cell["outputs"] if one.get("name") != "stderr"]
            shown = (one.get("text") or one["data"]["text/plain"] for one in outputs)
            yield "".join("".join(part) for part in shown)


def stored(path):
    return json.loads(path.read_text("utf-8"))
