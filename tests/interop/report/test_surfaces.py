"""The cursor on surfaces of a page in a browser: numbers as hfc explain."""

import json
import re

import browser
import pytest
from surfaces import CASES, asked, lesson, same


@pytest.fixture(scope="module")
def written():
    return lesson()


ACTIONS = """<script>
const found = CASES.map(([unit, places]) => places.map(([c, r]) => {
  const { rules, output } = fired(unit, c, r);
  return [rules.map(({ i, j, share, consequent }) => [unit.row.terms[i].label,
    unit.column.terms[j].label, share, consequent]), output];
}));
const own = surfaces[0], steps = [];
const tell = () => steps.push({ row: own.boxes.row.value, column: own.boxes.column.value,
  says: own.says.textContent, peaks: own.place.querySelectorAll(".peak").length,
  rules: [...own.body.rows].map((line) => [...line.cells].map((cell) => cell.textContent)) });
const type = (box, value) => { box.value = value; box.dispatchEvent(new Event("input")); };
const press = (key, shiftKey = false) => own.place.dispatchEvent(
  new KeyboardEvent("keydown", { key, shiftKey, cancelable: true }));
type(own.boxes.row, 10); type(own.boxes.column, 1); tell();
own.place.focus();
const kept = [press("ArrowUp"), press("ArrowRight", true), press("a")]; tell();
const box = own.place.getBoundingClientRect();
const point = (kind, x, y, buttons) => own.place.dispatchEvent(new PointerEvent(kind, { buttons,
  pointerType: "touch", clientX: box.left + x * box.width, clientY: box.top + y * box.height }));
point("pointerdown", 0.5, 0.5, 1); tell();
point("pointermove", 1, 0, 1); tell();
point("pointermove", 0, 0, 0); type(own.boxes.row, 1e9); tell();
type(own.boxes.row, ""); tell();  // which letters are for a box of numbers
const invalid = [own.boxes.row, own.boxes.column].map((box) => box.getAttribute("aria-invalid"));
own.boxes.row.dispatchEvent(new Event("change")); tell();
type(own.boxes.row, 2); tell();
const links = [...document.links].map((link) => link.hash);
document.body.textContent = JSON.stringify({ found, steps, kept, invalid, links,
  left: own.boxes.row.hasAttribute("aria-invalid"), title: document.title,
  focused: document.activeElement === own.place, bold: document.querySelector("b") !== null });
</script>"""


def test_the_script_says_what_explain_says(written, tmp_path):
    told = {case: asked(case) for case in CASES}
    cases = json.dumps([[numbers, places] for numbers, places, _ in told.values()])
    acting = ACTIONS.replace("CASES", cases)
    free = re.sub(r"<meta http-equiv[^>]*>", "", written)
    (tmp_path / "page.html").write_text(free.replace("</body>", acting + "</body>"))
    dom, said = browser.shown(tmp_path / "page.html", tmp_path)
    assert said == []
    answer = json.loads(re.search(r"<body>({.*})", dom)[1].replace("&amp;", "&"))
    for (_, _, own), found in zip(told.values(), answer["found"], strict=True):
        for (rules, output), wanted in zip(found, own, strict=True):
            same({(a, b): (share, x) for a, b, share, x in rules}, output, wanted)
    typed, moved, middle, corner, beyond, none, still, again = answer["steps"]
    assert typed["says"] == "command = 34 unit; 4 rules fire"
    assert typed["peaks"] == 4
    assert typed["rules"] == [
        ["Z", "Z", "46.67 %", "none 0"],
        ["P", "Z", "46.67 %", "more 60"],
        ["Z", "P", "3.33 %", "more 60"],
        ["P", "P", "3.33 %", "forward 120"],
    ]
    # The sides reach to 25 BLU and 18.75 BLU: steps of 0.1.
    assert (moved["row"], moved["column"]) == ("10.1", "2")
    assert answer["kept"] == [
        False,
        False,
        True,
    ]  # arrow keys do not scroll, others do what they do
    assert answer["focused"]
    assert (float(middle["row"]), float(middle["column"])) == (0.0, 0.0)
    assert middle["says"] == "command = 0 unit; 1 rule fires"
    assert (corner["row"], corner["column"]) == ("25", "18.75")
    assert beyond["says"] == corner["says"] == "command = 120 unit; 1 rule fires"
    assert none["says"].endswith(": a number from \u221225 to 25 is needed")
    assert (none["peaks"], none["rules"]) == (0, [])
    assert still == none
    assert answer["invalid"] == ["true", None]
    assert again["says"].startswith("command = ")
    assert not answer["left"]
    assert answer["links"] == ["#surface-1"]
    assert answer["title"] != "x"
    assert not answer["bold"]


def test_the_page_as_it_is(written, tmp_path):
    (tmp_path / "page.html").write_text(written)
    dom, said = browser.shown(tmp_path / "page.html", tmp_path)
    assert said == []
    assert dom.count('class="place"') == dom.count('aria-live="polite"') == 1
    assert re.search(r'class="place" tabindex="0"[^>]*role="application"', dom)
    bare = re.sub(r"(?s)<script>.*?</script>", "", written)
    (tmp_path / "bare.html").write_text(bare)
    dom, said = browser.shown(tmp_path / "bare.html", tmp_path)
    assert said == []
    assert 'class="place"' not in dom
    assert dom.count("<img") == written.count("<img")
    on_paper = [browser.printed(tmp_path / name, tmp_path) for name in ("page.html", "bare.html")]
    assert on_paper[0] == on_paper[1]
    typing = "<script>surfaces[0].boxes.row.oninput();</script></body>"
    free = re.sub(r"<meta http-equiv[^>]*>", "", written).replace("</body>", typing)
    (tmp_path / "moved.html").write_text(free)
    assert browser.printed(tmp_path / "moved.html", tmp_path) != on_paper[1]
