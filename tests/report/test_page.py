import base64
import re
import shutil
from html.parser import HTMLParser

import phone
import pytest
from random_runs import diverged

from hfc_design.core.records import RunError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.report.page import write_page
from hfc_design.report.verdict import baselines
from hfc_design.runs.run import Result, new_run
from hfc_design.simulation.evaluating import evaluate


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses, self.images = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.tags.append(tag)
        self.addresses += [found[key] for key in ("src", "href", "xlink:href") if key in found]
        if tag == "img":
            self.images.append(found)


def test_report_stands_alone_and_is_small(report):
    text = report[1].read_text()
    page = Page(text)
    assert len(text) < 1_000_000
    assert page.addresses
    assert all(address.startswith("data:") for address in page.addresses)
    assert "url(" not in text
    assert "@import" not in text
    assert "link" not in page.tags
    for picture in page.images:
        drawing = base64.b64decode(picture["src"].partition(",")[2]).decode()
        assert all(address.startswith(("#", "data:")) for address in Page(drawing).addresses)
        assert picture["alt"]


def test_report_escapes_what_a_user_wrote(report):
    text = report[1].read_text()
    tags = Page(text).tags
    assert tags.count("script") == 5  # the page's own, and numbers of four units
    assert tags.count("img") == tags.count("figure") == 12
    assert text.count("&lt;script&gt;") == 3  # description, configuration, provenance


def test_report_tells_fitness_rivals_and_structures(report):
    (scenario, result, folder, rivals), path = report
    text = path.read_text()
    assert f"{result.evaluation.fitness:.1f} on {scenario.name}" in text
    for evaluation in (result.evaluation, *rivals.values()):
        assert f"{evaluation.fitness:.4f}" in text
    assert "73 individuals diverged" in text
    assert text.count('</th><td class="value">110.0</td>') == 1
    assert len(re.findall(r'<tr><th scope="row">\(', text)) == 10
    assert sorted(file.name for file in (folder / "tables").iterdir()) == sorted(
        ["manifest.csv", *(f"unit-{unit.id}.csv" for unit in result.design.controller.units)]
    )


def test_same_run_gives_the_same_bytes(report):
    arguments, path = report
    first = path.read_bytes()
    write_page(*arguments)
    assert path.read_bytes() == first


@pytest.mark.slow
def test_report_of_diverged_designs(report, tmp_path):
    (scenario, result, folder, rivals), _ = report
    shutil.copy(folder / "config.toml", tmp_path)
    lost = diverged(scenario)
    write_page(scenario, result._replace(evaluation=lost), tmp_path, {"pd-only": lost})
    text = (tmp_path / "report.html").read_text()
    assert "diverges on c-axis-ramp-cutting" in text
    assert text.count(">diverged<") == 4  # fitness and merit of two designs
    write_page(scenario, result, tmp_path, rivals | {"lin-lee-1999-table-1": lost})
    assert "Table I of Lin &amp; Lee (1999) diverges" in (tmp_path / "report.html").read_text()


@pytest.mark.browser
def test_report_in_a_browser_as_wide_as_a_phone(report, tmp_path):
    assert phone.figures_that_fit(report[1], tmp_path) == 12


def test_tables_are_not_written_through_a_link(tmp_path):
    """It may lead to tables of others, which have the same names."""
    folder = tmp_path / "run"
    scenario = new_run(load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1}), folder)
    design, others = load_design("lin-lee-1999-table-1"), tmp_path / "others"
    others.mkdir()
    (others / "manifest.csv").write_text("precious")
    (folder / "tables").symlink_to(others)
    result = Result(design, evaluate(design, scenario), None)
    with pytest.raises(RunError, match="is a link"):
        write_page(scenario, result, folder, {})
    assert [file.read_text() for file in others.iterdir()] == ["precious"]


def test_the_loop_of_one_machine_is_a_rival_on_that_machine_only():
    stage = {"name": "x", "plant": {"name": "positioning-stage"}}
    stage |= {"reference": {"kind": "step", "height": 0.01}, "controller": {"kind": "pid"}}
    assert [*baselines(load_scenario(stage))] == ["emps-cascade"]
    assert not baselines(load_scenario(stage, {"plant.parameters.mass": 40.0}))
    other = load_scenario("c-axis-ramp", {"plant.parameters.stiffness": 150.0})
    assert len(baselines(other)) == 3
