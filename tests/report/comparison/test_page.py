"""The page of a comparison: nothing from outside, names are only text, curves can be zoomed."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser

import phone
import pytest
from browser import shown

from hfc_design.report.comparison.page import page
from hfc_design.report.latex import table


class Page(HTMLParser):
    """Elements, attributes, and the texts of scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.texts, self.ids, self.open = [], [], [], False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        self.texts.append("")
        self.open = True
        self.ids += [value for key, value in attributes if key == "id"]

    def handle_endtag(self, tag):
        self.open = False

    def handle_data(self, text):
        if self.open:
            self.texts[-1] += text

    def of(self, tag):
        pairs = zip(self.elements, self.texts, strict=True)
        return [(own, text) for (name, own), text in pairs if name == tag]


@pytest.fixture(scope="module")
def written(spindles):
    return page(spindles, "hfc compare <a> b").html.decode()


def test_the_same_comparison_gives_the_same_bytes(spindles, written):
    assert page(spindles, "hfc compare <a> b").html.decode() == written


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
    addresses = [x for _, own in found.elements for x in (own.get("src"), own.get("href")) if x]
    assert all(address.startswith("data:image/svg+xml") for address in addresses)
    assert "Permission is hereby granted" in written  # the licence of what is in it


def test_it_is_small_and_says_what_is_compared(written, tables):
    assert len(written) < 450_000
    assert "8 others" in written.replace("\n", " ")
    assert "<code>hfc compare &lt;a&gt; b</code>" in written
    other = page(tables).html.decode()
    assert other.count("times enlarged") == 2
    assert "Again:" not in other


def test_labels_in_latex_are_unique_over_comparisons(spindles, tables):
    """Of the same designs in other motions too, and captions name the motion once."""
    fewer = spindles._replace(bouts=spindles.bouts[:1])
    labels = []
    for comparison in (spindles, fewer, tables):
        found = page(comparison)
        texts = [table(k, own, found.of, found.label) for k, own in found.tables.items()]
        labels += [re.search(r"\\label\{(.*)\}", text)[1] for text in texts]
        for text in texts:
            caption = re.search(r"\\caption\{(.*)\}", text)[1]
            assert all(caption.count(bout.name) <= 1 for bout in comparison.bouts)
            of_designs = "the designs that are compared" in caption
            assert caption.count("machines within") == (not of_designs)
    assert len(labels) > 10
    assert len(labels) == len(set(labels))


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


@pytest.mark.browser
def test_curves_are_drawn_whatever_designs_are_called(written, tmp_path):
    (tmp_path / "page.html").write_text(written)
    dom, said = shown(tmp_path / "page.html", tmp_path)
    assert said == []
    found = Page(dom)
    assert len(found.of("canvas")) == 8  # four panels of two motions
    assert sum("live" in own.get("class", "").split() for own, _ in found.of("div")) == 2
    assert len(found.of("script")) == 3


@pytest.mark.browser
def test_zooming_takes_all_panels_of_a_motion_along(written, tmp_path):
    free = re.sub(r"<meta http-equiv[^>]*>", "", written)
    (tmp_path / "acting.html").write_text(free.replace("</body>", ACTIONS + "</body>"))
    dom, said = shown(tmp_path / "acting.html", tmp_path)
    assert said == []
    before, zoomed, after = json.loads(re.search("<pre>(.*)</pre>", dom)[1])
    low, high = before[0][0]
    assert (low, high) == (0, pytest.approx(2.0, abs=0.01))
    for found in zoomed[0]:
        assert found == [pytest.approx(0.5, abs=0.02), pytest.approx(1.0, abs=0.02)]
    assert zoomed[1] == before[1]  # another motion
    assert after == before


@pytest.mark.browser
def test_without_scripts_and_in_the_dark_the_pictures_stand_there(written, tmp_path):
    (tmp_path / "page.html").write_text(re.sub(r"(?s)<script>.*?</script>", "", written))
    dom, said = shown(tmp_path / "page.html", tmp_path, "--blink-settings=preferredColorScheme=0")
    assert said == []
    assert "live" not in {own.get("class") for own, _ in Page(dom).of("div")}


@pytest.mark.browser
def test_on_a_phone(spindles, tmp_path):
    (tmp_path / "page.html").write_bytes(page(spindles).html)
    # What all do in all motions, the ratios, the errors of two motions; not what is for print.
    assert phone.figures_that_fit(tmp_path / "page.html", tmp_path) == 4
