"""The page of a comparison in a browser: curves are drawn and can be zoomed."""

import json
import re

import phone
import pytest
from browser import shown
from html_page import Page

from hfc_design.report.comparison.page import page


@pytest.fixture(scope="module")
def written(spindles):
    return page(spindles, "hfc compare <a> b").html.decode()


ACTIONS = """<script>
const over = all[0].drawn.charts[1].over, box = over.getBoundingClientRect();
const mouse = (kind, share, place = over) => place.dispatchEvent(new MouseEvent(kind, {
  clientX: box.left + share * box.width, clientY: box.top + 20, bubbles: true, movementX: 5 }));
const ranges = () => all.map(({ drawn }) => drawn.charts.map((one) => one.scales.x));
const told = () => JSON.parse(JSON.stringify(ranges())).map((motion) =>
  motion.map(({ min, max }) => [min, max]));
const steps = [told()];
mouse("mouseenter", 0.25); mouse("mousemove", 0.25); mouse("mousedown", 0.25);
mouse("mousemove", 0.5); mouse("mouseup", 0.5, document);
setTimeout(() => {
  steps.push(told());
  document.querySelector(".traces button").click();
  setTimeout(() => {
    steps.push(told());
    document.body.innerHTML = "<pre>" + JSON.stringify(steps) + "</pre>";
  }, 100);
}, 100);
</script>"""


def test_curves_are_drawn_whatever_designs_are_called(written, tmp_path):
    (tmp_path / "page.html").write_text(written)
    dom, said = shown(tmp_path / "page.html", tmp_path)
    assert said == []
    found = Page(dom)
    assert len(found.of("canvas")) == 8  # four panels of two motions
    assert sum("live" in own.get("class", "").split() for own, _ in found.of("div")) == 2
    assert len(found.of("script")) == 3


def test_zooming_takes_all_panels_of_a_motion_along(written, tmp_path):
    free = re.sub(r"<meta http-equiv[^>]*>", "", written)
    (tmp_path / "acting.html").write_text(free.replace("</body>", ACTIONS + "</body>"))
    dom, said = shown(tmp_path / "acting.html", tmp_path)
    assert said == []
    before, zoomed, after = json.loads(re.search("<pre>(.*)</pre>", dom)[1])
    low, high = before[0][0]
    assert (low, high) == (0, pytest.approx(0.5, abs=0.01))
    for found in zoomed[0]:
        assert found == [pytest.approx(0.125, abs=0.005), pytest.approx(0.25, abs=0.005)]
    assert zoomed[1] == before[1]  # another motion
    assert after == before


def test_without_scripts_and_in_the_dark_the_pictures_stand_there(written, tmp_path):
    (tmp_path / "page.html").write_text(re.sub(r"(?s)<script>.*?</script>", "", written))
    dom, said = shown(tmp_path / "page.html", tmp_path, "--blink-settings=preferredColorScheme=0")
    assert said == []
    assert "live" not in {own.get("class") for own, _ in Page(dom).of("div")}


def test_on_a_phone(spindles, tmp_path):
    (tmp_path / "page.html").write_bytes(page(spindles).html)
    # What all do in all motions, the ratios, the errors of two motions; not what is for print.
    assert phone.figures_that_fit(tmp_path / "page.html", tmp_path) == 4
