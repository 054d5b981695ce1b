"""The page on a design names what to connect and how it was measured; vectors reach far."""

import re
from html import unescape

import made_up
import numpy as np
import pytest
from deployment_folders import page, vectors
from exported import texts
from markdown_it import MarkdownIt
from run_folders import hfc

from hfc_design.files.design import design_json, named_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats.deployment.single_precision import tolerance
from hfc_design.formats.writing import plain


def sensed(name, **sensors):
    """A built-in design whose scenario has these sensors."""
    design = named_design(name)
    own = load_scenario(design.provenance["scenario"]).model_dump(mode="json", exclude_none=True)
    return design.model_copy(update={"provenance": {"scenario": own | {"sensors": sensors}}})


def test_the_page_says_how_velocities_were_formed():
    text = page(
        sensed("pd-only", velocity="encoder", difference_samples=3, encoder_resolution=1e-5)
    )
    assert "backward differences of the readings over 3 samples, not filtered" in text
    assert "read in steps of 1e-05 rad" in text
    text = page(sensed("pd-only", velocity="observer", observer_hz=100.0))
    assert "The velocities in `error_rate` come from a tracking observer of 100.0 Hz" in text


def test_the_page_ends_with_what_counts_of_the_score():
    score = {"scenario": "two moves", "fitness": 3.0, "judged_by": "x", "chaotic": True}
    score |= {f"{move}_rms_error_mm": x for move, x in {"there": 1.5e-3, "back": -2.5e-3}.items()}
    score |= {"there_peak_voltage_V": 6.0, "back_settling_time_s": 1.0, "there_stick_events": 4.0}
    score |= {"usable": {"share": 0.984, "spread": 0.03, "machines": 1000}}
    text = page(named_design("pd-only").model_copy(update={"score": score}))
    assert text.index("## Connect") < text.index("## Check") < text.index("## Origin")
    assert text.index("## Origin") < text.index("- made by hfc-design")
    rows = re.findall(r"\n\| `(\w+)` \| (\S+) \| `(\w+)` \|(?=\n)", text)
    assert rows == [("rms_error_mm", "-0.0025", "back"), ("peak_voltage_V", "6", "there")]
    passed = "passes on 98.4 % of 1000 machines with parameters within 3 %"
    assert f"- **not usable as it is**: {passed}" in text
    assert "- chaotic when it was scored" in text
    assert "targets missed" not in text
    missed = {"rms_error": {"times": 910.0, "motion": "there"}}
    score["usable"]["missed"] = missed
    text = page(named_design("pd-only").model_copy(update={"score": score}))
    missed = "targets missed, value divided by target in the worst motion: rms_error 910 (there)"
    assert f"within 3 %; {missed}" in text
    for verdict, told in (
        ("yes", "- usable on 98.4"),
        ("on this model only", "not under stress: p"),
    ):
        score["usable"]["verdict"] = verdict
        assert told in page(named_design("pd-only").model_copy(update={"score": score}))
    score["usable"]["missed"] = {"rms_error": 3}  # has been edited
    assert "targets missed" not in page(named_design("pd-only").model_copy(update={"score": score}))
    for left_out in ("fitness", "settling", "stick", "judged"):
        assert left_out not in text
    assert "measure" not in page(named_design("pd-only"))


TEXTS = ("<b>*/ #include [x](y) `", "a_b and _c_ __d__ \\ ~~e~~ &lt; | f", "2*3*4 ![p](q) <!-- r")


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_is_read_as_it_was_written(text):
    read = MarkdownIt("commonmark").enable(["table", "strikethrough"]).render
    assert unescape(read(f"of {plain(text)}")) == f"<p>of {text}</p>\n"
    (cell,) = re.findall("<td>(.*)</td>", read(f"| x |\n|---|\n| {plain(text)} |"))
    assert unescape(cell) == text


def test_nothing_that_a_user_wrote_is_markup_or_code():
    evil = "<b>*/ #include [x](y) `"
    design = named_design("pd-only")
    own = {"name": evil, "score": {evil: 1.0}, "provenance": {"source": evil}}
    found = texts(design.model_copy(update=own), "c")
    read = MarkdownIt("commonmark").enable("table").render(found["README.md"])
    tags = {"h1", "h2", "p", "ul", "li", "code", "pre", "table", "thead", "tbody", "tr", "th", "td"}
    assert set(re.findall(r"<(\w+)", read)) <= tags
    assert "&lt;b&gt;*/ #include [x](y) `" in read
    for text in (found["Makefile"], found["check/check.c"], found["check/vectors.csv"]):
        assert "<b>" not in text
        assert "#include [" not in text


def test_single_precision_is_compared_until_a_decision_is_close():
    """By hand: the last 50 samples of a command of 100 are twice as far off in one of the tries."""
    commands = np.full((1000, 1), 100.0)
    near = commands + 2e-5
    far = commands + 1e-4 * (np.arange(1000) >= 970)[:, None]
    found = tolerance(commands, [near, commands], [far])
    assert found.double == 1e-10
    assert found.single == pytest.approx(8e-5, rel=1e-9)
    assert all(found.alike)  # what is a few times as far off has no other reason
    far[970:] += 0.01
    found = tolerance(commands, [near, commands], [far])
    assert [k for k, alike in enumerate(found.alike) if not alike] == list(range(970, 1000))
    far[400] += 0.01  # all is forgotten before sample 550
    found = tolerance(commands, [near, commands], [far])
    assert sum(found.alike) == 1000 - 150 - 30
    exact = tolerance(commands, [commands], [commands])
    assert exact.single == pytest.approx(2.0**-21 * 100.0)


def test_the_vectors_go_beyond_the_ends_of_the_universe():
    names, numbers, _ = vectors(texts(named_design("lin-lee-1999-table-1"), "c"))
    record = named_design("lin-lee-1999-table-1").controller
    for item in record.inputs:
        column = numbers[:, names.index(item.name.removeprefix("previous_"))] * item.scale
        assert column.min() < -1.2
        assert column.max() > 1.2
        assert ((np.abs(column) < 0.1) & (column != 0)).sum() > 30


def test_an_export_warns_of_a_design_that_is_not_usable(tmp_path):
    design = named_design("pd-only")
    for share, warned in ((0.199, True), (0.995, False)):
        told = {"usable": {"share": share, "machines": 1000, "spread": 0.2}}
        path = tmp_path / f"{share}.json"
        path.write_text(design_json(design.model_copy(update={"score": told})))
        done = hfc("export", path, "--to", "st", "--out", tmp_path / f"{share}")
        assert done.exit_code == 0, done.output
        said = "warning: design pd-only: not usable as it is: passes on 19.9 %"
        assert (said in done.stderr) == warned


def test_the_page_says_what_is_filtered_and_limited():
    filtered = made_up.limited(made_up.linear("pid+ff", 4), 40.0)
    own = filtered.controller.model_copy(update={"derivative_hz": 90.0})
    text = page(filtered.model_copy(update={"controller": own}))
    assert "`error_rate` passes a low-pass of the first order at 90.0 Hz" in text
    assert "The command is limited to 40.0 V of either sign" in text
    assert "The command is not limited" in page(named_design("pd-only"))


def test_the_page_of_a_design_without_an_answer_says_so():
    assert "its scenario has no `[robust]`: see `hfc score`" in page(named_design("pd-only"))


def test_the_page_has_what_the_design_was_tried_under():
    """Of a file that was edited: nothing of it, and no markup."""
    held = {"name": "2 times | *the* noise", "holds": True, "share": 1.0, "merit": 0.8}
    broken = {"name": "a backlash of 3 steps", "holds": False, "share": 0.25, "merit": 0.0}
    broken |= {"part": 0.5, "breaks": "a backlash of 1.5 steps", "why": "oscillates in there"}
    used = {"share": 0.99, "spread": 0.03, "machines": 1000, "stress": [held, broken]}
    design = named_design("pd-only").model_copy(update={"score": {"usable": used}})
    text = page(design)
    assert "| stress | stable on [%] | merit [times] |\n|---|---|---|\n" in text
    assert "\n| 2 times \\| \\*the\\* noise | 100 | 0.80 |\n" in text
    assert "\n| a backlash of 3 steps | 25 | breaks |\n" in text
    assert "\n- breaks: with a backlash of 1.5 steps it oscillates in there\n" in text
    for wrong in (3, [held, 3], [{}]):
        used["stress"] = wrong
        assert "| stress |" not in page(design)


def test_a_signal_whose_gain_is_zero_is_said_not_to_be_used():
    design = made_up.limited(made_up.linear("pid+ff", 4), 40.0)
    gains = design.controller.feed_forward

    def idle(**own):
        changes = {"feed_forward": gains.model_copy(update=own)}
        controller = design.controller.model_copy(update=changes)
        text = page(design.model_copy(update={"controller": controller}))
        return re.findall(r"\| `(\w+)` \| in \| \S+ \| not used, gain 0 \|", text)

    assert idle(acceleration=1.0, velocity=1.0) == []
    assert idle(acceleration=0.0, velocity=1.0) == ["reference_acceleration"]
