"""What the terminal says of whether a design can be used: the table, the picture, one motion."""

from hfc_design.cli.scoring import WARNING, again_told, show_usable


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
    # Share, error [urad] median and 95 %, chatter median and largest, peak the same, at limit.
    assert rows["a"] == ["100", "2", "3", "2", "4", "20", "40", "0"]
    assert rows["b"] == ["98", "4", "6", "4", "8", "40", "80", "25"]
    text = " ".join(told.out.split())
    assert "settled rms error | chatter | peak | at limit" in text
    assert "[urad]" in text
    assert "98 % (89.35 to 99.95 % with 95 % confidence) pass: stable" in text
    assert "still passes with the command multiplied by 0.5 to 1.26" in text
    assert "numerics: merit changes by 1.2 % in float64, 0.34 % with finer time steps" in text
    assert told.err == WARNING + "\n"


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
    assert "\n31 oscillate in b\nlost by it: machines" in below
    assert max(map(len, told.splitlines())) <= 80


def test_a_machine_that_runs_away_has_no_numbers(capsys):
    """An error of 1e7 rad is 1e13 urad; a table of such numbers says nothing."""
    lost = of_motion(0.8, 1.0, 0.0)
    lost["measures"]["settled_rms_error"]["q95"] = 1.07e7
    lost["measures"]["peak_command"]["largest"] = 2.16e12
    show_usable(ANSWER | {"motions": {"a": lost}})
    (row,) = (x.split()[1:] for x in capsys.readouterr().out.splitlines() if x.startswith("a "))
    assert row == ["80", "2", "diverges", "2", "4", "20", "diverges", "0"]


def test_chaos_is_told_in_a_line(capsys):
    show_usable(ANSWER | {"chaotic": True, "repeats": {"lowest": 189.34, "highest": 686.4}})
    text = " ".join(capsys.readouterr().out.split())
    repeats = "in 64 repeats with the command changed by up to one millionth"
    assert f"merit is chaotic: {repeats}, it ranges from 189.3 to 686.4" in text
    show_usable(ANSWER | {"chaotic": True, "repeats": {"lowest": None, "highest": 686.4}})
    assert "it ranges from diverged to 686.4" in " ".join(capsys.readouterr().out.split())


def test_a_design_that_can_be_used_is_not_warned_of(capsys):
    show_usable(ANSWER | {"usable": True, "answer": "yes: all", "gain": None})
    told = capsys.readouterr()
    assert told.out.startswith("Can I use it? yes: all\n")
    assert told.err == ""
    assert "gain margin: none, the nominal machine does not pass" in told.out


def test_yes_does_not_stand_alone_where_a_tolerance_is_missed(capsys):
    missed = {"settled_rms_error": {"times": 910.3, "motion": "b"}}
    show_usable(ANSWER | {"usable": True, "answer": "yes: all", "missed": missed})
    text = " ".join(capsys.readouterr().out.split())
    missed = (
        "targets missed, value divided by target in the worst motion: settled_rms_error 910 (b)"
    )
    assert text.startswith(f"Can I use it? yes: all {missed} ")


def test_a_machine_that_cannot_be_drawn_is_said_to_be_none(capsys):
    show_usable(None)
    assert "Unknown: there is no machine" in capsys.readouterr().out


def test_another_seed_is_named_only_where_it_may_help():
    assert again_told(ANSWER, 3).startswith("To get a usable design, try --seed 3, twice the")
    assert again_told(ANSWER | {"verdict": "on this model only"}, 3) == ""
    assert again_told(ANSWER | {"usable": True}, 3) == again_told(None, 3) == ""
