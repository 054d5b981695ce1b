"""The page of a run: it stands alone, is small, and says what was found."""

import base64
import re
import shutil

from html_page import Page
from report_pages import lost, write
from wording import refused

from hfc_design.core.records import RunError
from hfc_design.report.parts import summary


def test_it_tells_fitness_rivals_and_structures(report):
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


def test_it_stands_alone_is_small_and_escapes_what_a_user_wrote(report):
    text = report[1].read_text()
    page = Page(text)
    assert len(text) < 1_000_000
    assert page.addresses
    assert all(address.startswith("data:") for address in page.addresses)
    assert "url(" not in text
    assert "@import" not in text
    assert not page.of("link")
    assert len(page.of("script")) == 5  # the page's own, and numbers of four units
    assert len(page.of("img")) == len(page.of("figure")) == 13
    for picture, _ in page.of("img"):
        drawing = base64.b64decode(picture["src"].partition(",")[2]).decode()
        assert all(address.startswith(("#", "data:")) for address in Page(drawing).addresses)
        assert picture["alt"]
    assert text.count("&lt;script&gt;") == 3  # description, configuration, provenance


def test_the_same_run_gives_the_same_bytes(report):
    arguments, path = report
    first = path.read_bytes()
    write(*arguments)
    assert path.read_bytes() == first


def test_whether_it_can_be_used(report):
    text = report[1].read_text()
    places = [text.index(part) for part in ("Can I use it?", "only 99.6 %", "<img", "<table")]
    assert places == sorted(places)  # the answer, the picture that shows it, and then tables
    part = text[text.index("On other machines") : text.index("The controller</h2>")]
    heads = re.findall(r'<th scope="col"[^>]*>(.*?)</th>', part)
    assert heads[1:3] == ["pass [%]", "settled rms error [µrad]"]
    rows = re.findall(r'<tr><th scope="row">(.*?)</tr>', part)
    cells = [re.split("<[^>]+>", row)[0::2] for row in rows]
    assert [cell[0] for cell in cells] == ["ramp *", "position"]
    assert part.count("* is required on the nominal machine only.") == 1
    assert "passes with the command multiplied by 0.455 to at least 16." in part
    assert cells[0][1:4] == ["100", "3.57 / 3570", "3.79 / 3790"]
    assert cells[1][1:3] == ["99.8", "7.14 / 7140"]
    named = re.findall("<dt>(.*?)</dt>", part)  # every reason that follows is explained
    assert {*named} >= {"is far off", "oscillates", "stays at a limit"}
    (why,) = re.findall("<li>(.*?)</li>", part)  # of those motions that some do not keep
    assert why == "position: 2 oscillate, 2 exceed unsettled, 1 is far off, 1 stays at a limit"


def test_diverged_designs_are_said(report, tmp_path):
    (scenario, result, folder, _), _ = report
    shutil.copy(folder / "config.toml", tmp_path)
    gone = lost(result.evaluation)
    rivals = {"lin-lee-1999-table-1": gone}
    write(scenario, result._replace(evaluation=gone), tmp_path, rivals)
    text = (tmp_path / "report.html").read_text()
    assert "The controller diverges on c-axis-ramp-cutting: it runs away." in text
    assert text.count(">diverged<") == 4  # fitness and merit of two designs
    told = summary(scenario, result.evaluation, rivals)
    assert told.endswith(": Table I of Lin & Lee (1999) diverges there: it runs away.")


def test_tables_are_not_written_through_a_link(report, tmp_path):
    """It may lead to tables of others, which have the same names."""
    (scenario, result, _, _), _ = report
    folder, others = tmp_path / "run", tmp_path / "others"
    folder.mkdir()
    others.mkdir()
    (others / "manifest.csv").write_text("precious")
    (folder / "tables").symlink_to(others)
    with refused(RunError) as found:
        write(scenario, result, folder, {})
    assert found.where == str(folder / "tables")
    assert [file.read_text() for file in others.iterdir()] == ["precious"]
