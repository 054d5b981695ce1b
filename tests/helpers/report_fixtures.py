"""Pages that several tests look at."""

import json
from types import SimpleNamespace

import pytest

# What these import draws, so that it is imported late.


@pytest.fixture(scope="session")
def report(tmp_path_factory):
    """The arguments of ``report_pages.write``, and the page of a run that it wrote."""
    from report_pages import run_page

    return run_page(tmp_path_factory.mktemp("report") / "run")


@pytest.fixture(scope="session")
def lone(tmp_path_factory):
    """The page of a design without a run, figures and tables for a paper beside it."""
    from report_pages import lone_page

    return lone_page(tmp_path_factory.mktemp("lone"))


@pytest.fixture
def known_use(monkeypatch):
    """Runs need not simulate whether their design can be used: that takes three programs."""
    from report_pages import USED

    from hfc_design.runs import champion, run

    told = SimpleNamespace(yes=True, numbers=lambda: json.loads(json.dumps(USED)))
    for module in (champion, run):
        monkeypatch.setattr(module, "usable", lambda *_, **__: told)
