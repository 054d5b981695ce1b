"""``hfc attainable``, and what a run tells of it: in the terminal, its folder, its page."""

import json

import pytest
from wording import refused

from hfc_design.core.records import RunError
from hfc_design.report.parts import usable_numbers
from hfc_design.runs.attained import ATTAINABLE, attained_rows, attained_told, kept_attained
from hfc_design.runs.run import USABLE, kept_use


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


TEXTS = ["", "{", "[]", '{"motions": 3}', '{"motions": {}}', '{"motions": {"a": {"bound": "no"}}}']
TEXTS += [
    "[" * 99_999,
    "9" * 9999,
    '{"motions": NaN}',
    '"' + "a" * 6_000_000 + '"',
    "\x00",
    '{"a": 1e999}',
]


@pytest.mark.parametrize(("name", "read"), [(ATTAINABLE, kept_attained), (USABLE, kept_use)])
def test_a_damaged_file_beside_a_design_is_refused(tmp_path, name, read):
    assert read(tmp_path) is None
    for text in TEXTS:
        (tmp_path / name).write_text(text)
        with refused(RunError) as found:
            read(tmp_path)
        assert found.where.startswith(str(tmp_path / name))
        assert len(found.refusal) - len(str(tmp_path)) < 300


def test_numbers_of_use_are_read_back_or_refused_key_by_key(tmp_path):
    """What a version that told less has written is read; what a page cannot show is not."""
    measure = {"nominal": 1.0, "median": 1.0, "q95": None, "largest": 2.0}
    motion = {
        "share": 0.5,
        "reasons": {"oscillates": 3},
        "measures": dict.fromkeys("abcd", measure),
    }
    good = {"usable": False, "answer": "no", "spread": 0.2, "machines": 9, "share": 0.5}
    good |= {"interval": [0.1, 0.9], "gain": None, "precision": 1e-6, "substeps": None}
    good |= {"units": dict.fromkeys("abc", "rad"), "motions": {"ramp": motion}}
    file = tmp_path / USABLE
    file.write_text(json.dumps(good))
    assert kept_use(tmp_path) == good
    usable_numbers(good)
    for key in good:
        for wrong in ({k: x for k, x in good.items() if k != key}, good | {key: [["x"]]}):
            file.write_text(json.dumps(wrong))
            with pytest.raises(RunError, match=key):
                kept_use(tmp_path)
