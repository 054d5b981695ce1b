"""``hfc attainable``, and what a run tells of it: in the terminal, its folder, its page."""

from hfc_design.runs.attained import ATTAINABLE, attained_rows, attained_told, kept_attained


def test_rows_and_the_line_of_a_design():
    one = {"bound": 0.02, "reached": 0.025, "sum_error": 0.05, "simple": 0.01, "samples": 9}
    found = {"unit": "rad", "motions": {"ramp": one}}
    assert attained_rows(found) == [["ramp", "0.02", "0.025", "0.05", "2.5", "2"]]
    assert attained_told(found) == (
        "sum |e| 0.05 rad: 2.5 times the certified bound 0.02, "
        "2 times the best open-loop voltage 0.025"
    )
    slow = attained_told(found | {"left_out": "limits.command_rate"})
    assert slow.endswith("the best open-loop voltage 0.025 (limits.command_rate is left out)")
    lost = {"motions": {"ramp": one | {"sum_error": None}}}
    assert attained_rows(lost) == [["ramp", "0.02", "0.025", "–", "–", "–"]]
    assert attained_told(lost) == ""
    nothing = {"motions": {"ramp": one | {"bound": 0.0, "reached": 0.0}}}
    assert attained_rows(nothing) == [["ramp", "0", "0", "0.05", "–", "–"]]


def test_a_file_that_was_edited_is_no_answer(tmp_path):
    for text in ("", "{", "[]", '{"motions": 3}', '{"motions": {"ramp": {"bound": "no"}}}'):
        (tmp_path / ATTAINABLE).write_text(text)
        assert kept_attained(tmp_path) is None
    assert kept_attained(tmp_path / "nowhere") is None
