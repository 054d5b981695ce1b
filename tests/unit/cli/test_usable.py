"""What the terminal says of how good a design is: its use and its distance to the bound."""

import json

import pytest
from wording import refused

from hfc_design.cli.scoring import WARNING, again_told, show_usable
from hfc_design.core.records import RunError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.attained import ATTAINABLE, attained_table, attained_told, kept_attained
from hfc_design.runs.run import USABLE, kept_use
from hfc_design.simulation.usable_tables import motions_table


def of_motion(share, factor, limited):
    quantiles = {"nominal": 1.0, "median": 2.0, "q95": 3.0, "largest": 4.0}
    scaled = {key: factor * x for key, x in quantiles.items()}
    return {
        "share": share,
        "measures": {
            "settled_rms_error": {key: 1e-6 * x for key, x in scaled.items()},
            "chatter": scaled,
            "peak_command": {key: 10.0 * x for key, x in scaled.items()},
            "limit_share": {**quantiles, "largest": limited},
        },
    }


ANSWER = {
    "usable": False,
    "answer": "no: only 98 % of 50 unseen machines within +-20 % pass; 1 oscillates in b",
    "spread": 0.2,
    "machines": 50,
    "share": 0.98,
    "interval": [0.8935, 0.9995],
    "gain": [0.5, 1.26],
    "precision": 0.012,
    "substeps": 0.0034,
    "units": {"settled_rms_error": "rad", "chatter": "V", "peak_command": "V"},
    "motions": {"a": of_motion(1.0, 1.0, 0.0), "b": of_motion(0.98, 2.0, 0.25)},
}


def test_the_table_by_hand(capsys):
    show_usable(ANSWER)
    told = capsys.readouterr()
    lines = told.out.splitlines()
    assert lines[0].startswith("Can I use it? no: only 98 % of 50 unseen machines")
    assert max(map(len, lines)) <= 80
    rows = {line.split()[0]: line.split()[1:] for line in lines if line[:2] in ("a ", "b ")}
    # Share, error [urad], chatter, peak and largest share at a limit.
    assert " ".join(rows["a"]) == "100 2 / 3 2 / 4 20 / 40 0"
    assert " ".join(rows["b"]) == "98 4 / 6 4 / 8 40 / 80 0.25"
    text = " ".join(told.out.split())
    assert "[urad]" in text
    share = "98 % (89.35 to 99.95 % with 95 % confidence) pass: stable"
    assert f"{share}; there are no constraints to meet" in text
    one = of_motion(0.98, 1.0, 0.0) | {"constraints": {"chatter": {"allowed": 5.0}}}
    show_usable(ANSWER | {"motions": {"a": one}})
    assert f"{share}, all constraints met" in " ".join(capsys.readouterr().out.split())
    assert "still passes with the command multiplied by 0.5 to 1.26" in text
    assert "numerics: merit changes by 1.2 % in float64, 0.34 % with finer time steps" in text
    assert told.err == WARNING + "\n"


@pytest.mark.parametrize(
    ("changes", "advice"),
    [
        ({"precision": 0.28}, "search again with --precision float64"),
        ({"substeps": 0.06}, "search again with four times simulation.substeps"),
        ({"precision": 0.28, "chaotic": True, "repeats": [1.0, 2.0]}, ""),
        ({"precision": 0.04, "substeps": None}, ""),
    ],
)
def test_numbers_that_are_too_coarse_get_advice(changes, advice, capsys, monkeypatch):
    monkeypatch.setattr("hfc_design.simulation.acceptance.merit_text", lambda numbers: "")
    show_usable(ANSWER | changes)
    text = " ".join(capsys.readouterr().out.split())
    assert advice in text
    assert ("too coarsely" in text) == bool(advice)


def test_a_no_says_what_would_give_a_yes(capsys):
    change = {"key": "constraints.late_error", "now": "2 mrad", "needed": "2.6 mrad", "lost": 31}
    other = {"key": "robust.spread", "now": "0.2", "needed": None, "lost": None, "without": 0.955}
    why = {"changes": [change | {"without": 0.998}, other], "lines": ["31 oscillate in b"]}
    show_usable(ANSWER | {"why_not": why})
    told = capsys.readouterr().out
    _, _, below = told.partition("Changes that would give a yes, each on its own:\n")
    rows = [line.split() for line in below.splitlines()]
    assert ["constraints.late_error", "2", "mrad", "2.6", "mrad", "31", "99.8"] in rows
    assert ["robust.spread", "0.2", "-", "-", "95.5"] in rows
    assert "\n31 oscillate in b\n" in below
    assert "\nLost by it: machines" in below
    assert max(map(len, told.splitlines())) <= 80


def test_rows_and_the_line_of_a_design():
    one = {"bound": 0.02, "reached": 0.025, "sum_error": 0.05, "simple": 0.01, "samples": 9}
    found = {"unit": "rad", "motions": {"ramp": one}}
    assert attained_table(found).rows == [["ramp", "0.02", "0.025", "0.05", "2.5", "2"]]
    assert attained_told(found) == (
        "sum |e| 0.05 rad: 2.5 times the certified bound 0.02, "
        "2 times the best open-loop voltage 0.025"
    )
    slow = attained_told(found | {"left_out": "limits.command_rate"})
    assert slow.endswith("the best open-loop voltage 0.025 (left out: limits.command_rate)")
    lost = {"motions": {"ramp": one | {"sum_error": None}}}
    assert attained_table(lost).rows == [["ramp", "0.02", "0.025", "–", "–", "–"]]
    assert attained_told(lost) == ""
    nothing = {"motions": {"ramp": one | {"bound": 0.0, "reached": 0.0}}}
    assert attained_table(nothing).rows == [["ramp", "0", "0", "0.05", "–", "–"]]


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
    (row,) = motions_table(good).rows
    assert row == ["ramp", "50", "1 / –", *["1 / 2"] * 3]
    (row,) = motions_table(good, largest=True).rows
    assert row == ["ramp", "50", *["1 / 2"] * 4]
    margins = {"worst": {"sensitivity": {"value": 2.0, "at": "rest"}}}
    file.write_text(json.dumps(good | {"margins": margins}))
    assert kept_use(tmp_path)["margins"] == margins
    del margins["worst"]["sensitivity"]["at"]
    for wrong in ({"margins": margins}, {"motions": {"ramp": motion | {"reasons": {"x": "y"}}}}):
        file.write_text(json.dumps(good | wrong))
        with pytest.raises(RunError):
            kept_use(tmp_path)
    for key in good:
        for wrong in ({k: x for k, x in good.items() if k != key}, good | {key: [["x"]]}):
            file.write_text(json.dumps(wrong))
            with pytest.raises(RunError, match=key):
                kept_use(tmp_path)


def test_advice_names_a_required_margin_that_the_loop_just_has_or_lacks():
    """c-axis-practical requires an Ms of at most 2: 1.9 is above nine tenths of it, 1.7 is not."""
    scenario = load_scenario("c-axis-practical")

    def told(ms, **more):
        worst = {"sensitivity": {"value": ms, "at": "at rest"}}
        return again_told({"usable": False, "margins": {"worst": worst}, **more}, scenario)

    assert told(1.9).endswith("or a looser constraints.sensitivity (1.9 at rest, allowed 2)")
    assert told(1.7).endswith("a smaller robust.spread or --controller pid+ff")
    assert told(None) == told(1.7)
    assert told(1.9, usable=True) == ""
