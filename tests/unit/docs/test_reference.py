"""The pages that are made from the code have all of it."""

import importlib.util
import re
import sys

import pytest
from doc_pages import PAGES, ROOT

from hfc_design.cli import main
from hfc_design.reference.entries import entries

SITE = ROOT / "docs" / "site"


@pytest.fixture(scope="module")
def staged(tmp_path_factory):
    """The folder that the site is built from."""
    sys.path.insert(0, str(SITE))
    spec = importlib.util.spec_from_file_location("stage", SITE / "stage.py")
    stage = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(stage)
    sys.path.remove(str(SITE))
    folder = tmp_path_factory.mktemp("site") / "pages"
    stage.stage(folder)
    return folder


def test_pages_keep_their_places(staged):
    for page in PAGES:
        text = (staged / page.relative_to(ROOT)).read_text("utf-8")
        assert text.partition("\n")[0] == page.read_text("utf-8").partition("\n")[0]
    # What pages link to of the sources is a page itself.
    assert "class State" in (staged / "examples" / "02_own_plant.py.md").read_text("utf-8")
    assert "(02_own_plant.py.md)" in (staged / "examples" / "index.md").read_text("utf-8")


def test_every_entry_of_the_reference_has_a_row(staged):
    every = "".join(page.read_text("utf-8") for page in (staged / "docs/reference").glob("*.md"))
    rows = set(re.findall(r"^\| `([^`]*)` \|", every, re.MULTILINE))
    heads = set(re.findall(r"^#+ (.*)$", every, re.MULTILINE))
    for one in entries():
        if one.part == "fact" or one.kind in ("scenario", "design"):
            continue
        assert one.key in rows or one.name in rows | heads, one


def test_every_command_has_its_options(staged):
    text = (staged / "docs" / "reference" / "command-line.md").read_text("utf-8")
    sections = dict(re.findall(r"^## hfc (\S+)\n(.*?)(?=^## |\Z)", text, re.M | re.S))
    assert list(sections) == list(main.commands)
    for name, command in main.commands.items():
        for option in command.params:
            if option.param_type_name == "option":
                assert option.opts[0] in sections[name], f"{name} {option.opts[0]}"
        assert "| `-h, --help` |" in sections[name]
        assert "```sh\nhfc " + name in sections[name], f"{name} has no example"
