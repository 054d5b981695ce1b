"""Signals made of columns: units, times that tremble, samples that are missing or cut off."""

import numpy as np
import pytest
from shaken import shaken
from wording import refused

from hfc_design.logs import signals as limits
from hfc_design.logs.columns import Log, parse_columns
from hfc_design.logs.signals import saturated, signals
from plants import PLANTS

STAGE = PLANTS["positioning-stage"]
TIME = np.arange(400) * 1e-3
PLACE = 3.0 * np.sin(20 * TIME)  # mm
VOLTS = np.sin(20 * TIME + 1)


def found(columns, *told, breaks=None, sample_time=None, drive=STAGE):
    log = Log(columns, None, breaks)
    return signals(log, drive, parse_columns(told, drive), sample_time)


def test_units_of_people_and_of_encoders():
    """The same motion in m, in counts of 5 um and in the drive's mm."""
    told = found({"t": 1e3 * TIME, "q": PLACE / 1e3, "u": 1e3 * VOLTS},
                 "time=t [ms]", "position=q [m]", "command=u [mV]")  # fmt: skip
    counted = found({"t": TIME, "enc": PLACE / 5e-3, "u": VOLTS},
                    "time=t", "position = enc [5 um]", "command=u [V]")  # fmt: skip
    for one in (told, counted):
        np.testing.assert_allclose(one.values["position"], PLACE, atol=1e-12)
        np.testing.assert_allclose(one.values["command"], VOLTS, atol=1e-12)
        assert one.sample_time == pytest.approx(1e-3)
        assert one.usable.all()
    assert told.notes == []
    assert counted.notes == ["time is t in s; another unit: NAME=COLUMN [UNIT]"]


def test_degrees_are_angles_and_on_a_straight_plant_ways_on_an_arm_of_a_metre():
    """As docs/identify.md names them."""
    angle, columns = 0.3 * PLACE, {"t_s": TIME, "p": np.degrees(0.3 * PLACE), "voltage_V": VOLTS}
    for unit, factor in (("deg", 1.0), ("mdeg", 1e3), ("arcsec", 3600.0), ("turn", 1.0 / 360.0)):
        own = columns | {"p": factor * columns["p"]}
        one = found(own, "time=t_s", f"spindle_angle=p [{unit}]", drive=PLANTS["c-axis"])
        np.testing.assert_allclose(one.values["spindle_angle"], angle, atol=1e-12)
    one = found(columns, "time=t_s", "position=p [17.4533 mm]")
    np.testing.assert_allclose(one.values["position"], 1e3 * angle, rtol=1e-5)


def test_a_column_that_is_named_without_a_unit_has_that_of_its_own_name():
    names = ("time=t_ms", "position=Pos_um", "command=U [mV]", "velocity=rate_of_m_s")
    columns = {"t_ms": 1e3 * TIME, "Pos_um": 1e3 * PLACE, "U [mV]": 1e3 * VOLTS}
    one = found(columns | {"rate_of_m_s": 1e-3 * PLACE}, *names)
    np.testing.assert_allclose(one.values["position"], PLACE, atol=1e-12)
    np.testing.assert_allclose(one.values["command"], VOLTS, atol=1e-12)
    np.testing.assert_allclose(one.values["velocity"], PLACE, atol=1e-12)
    assert one.sample_time == pytest.approx(1e-3)
    assert one.notes[0].startswith("time is t_ms in ms, position is Pos_um in um, velocity is ")
    other = found(
        {"t_ms": TIME, "pos_x": PLACE, "U": VOLTS}, "time=t_ms [s]", "position=pos_x", "command=U"
    )
    np.testing.assert_allclose(other.values["position"], PLACE)
    assert other.notes[0].startswith("position is pos_x in mm, command is U in V;")


def test_columns_are_known_by_their_names():
    """As ``hfc simulate --csv`` writes them, and as people do."""
    for names in (
        ("time_s", "position_mm", "voltage_V"),
        ("time [ms]", "position (um)", "command"),
    ):
        ms = 1e3 if "ms" in names[0] else 1.0
        um = 1e3 if "um" in names[1] else 1.0
        one = found(dict(zip(names, (ms * TIME, um * PLACE, VOLTS), strict=True)))
        np.testing.assert_allclose(one.values["position"], PLACE, atol=1e-12)
        assert one.sample_time == pytest.approx(1e-3)


@pytest.mark.parametrize("end", ["kg", "raw", "counts", "c", "error_um"])
def test_a_name_that_ends_in_no_unit_of_the_signal_is_not_it(end):
    """Counts are no radians, and c is no speed of light, though a library of units says so."""
    told = {"time": TIME, f"spindle_angle_{end}": PLACE, f"position_{end}": PLACE, "command": VOLTS}
    for drive in (STAGE, PLANTS["c-axis"]):
        with refused(ValueError):
            found(told, drive=drive)


@pytest.mark.parametrize("name", ["p", "position [furlong]"])
def test_a_travel_that_no_machine_has_is_refused(name):
    """6 furlongs of 201.168 m in 0.4 s; at 1 km/s it were 400 m."""
    told = [] if "[" in name else ["position=p [furlong]"]
    with refused(ValueError):
        found({"time_s": TIME, name: PLACE, "command": VOLTS}, *told)
    with refused(ValueError):
        found({"time_s": TIME, "p": PLACE, "command": VOLTS}, "position=p [fm]")


def test_stamps_that_tremble_are_evened_out():
    """By a tenth of a period; the motion is 0.06 mm/ms fast, so that it is off uncorrected."""
    rng = np.random.default_rng(1)
    stamps = TIME + 1e-4 * rng.standard_normal(400)
    motion = 3.0 * np.sin(20 * stamps)
    one = found({"time_s": stamps, "position": motion, "command": VOLTS})
    expected, uneven = 3.0 * np.sin(20 * one.sample_time * np.arange(400)), 3.0 * np.sin(20 * TIME)
    middle = slice(2, -2)
    assert np.abs(one.values["position"] - expected)[middle].max() < 2e-3
    assert np.abs(motion - uneven).max() > 1e-2
    assert "jitter by 9" in one.notes[0] or "jitter by 10" in one.notes[0]


def test_samples_that_are_missing_are_filled_in_and_not_used():
    kept = np.ones(400, bool)
    kept[[100, 101, 250]] = False
    one = found({"time_s": TIME[kept], "position": PLACE[kept], "command": VOLTS[kept]})
    assert np.flatnonzero(~one.usable).tolist() == [100, 101, 250]
    np.testing.assert_allclose(one.values["position"], PLACE, atol=2e-3)
    assert one.values["command"][101] == VOLTS[99]  # it stays
    assert one.notes == ["3 of 400 samples are missing"]


def test_stamps_that_several_samples_share_tell_the_sample_time():
    """A clock of 10 ms as it is written, rounded; one of 15.625 ms; one finer than the samples."""
    for stamps in (np.round(TIME, 2), TIME // 0.015625 * 0.015625, TIME // 0.0013 * 0.0013):
        one = found({"time_s": stamps, "position": PLACE, "command": VOLTS})
        np.testing.assert_array_equal(one.values["position"], PLACE)
        assert one.sample_time == pytest.approx(1e-3, rel=2e-3)
        assert "share a time stamp" in one.notes[0]
    assert found({"time_s": np.round(TIME, 2), "position": PLACE, "command": VOLTS}).step is None
    twice = {"time_s": np.repeat(TIME, 2), "position": np.repeat(PLACE, 2)}  # a row written twice
    one = found(twice | {"command": np.repeat(VOLTS, 2)})
    assert (one.sample_time, len(one.usable)) == (1e-3, 400)
    kept = (TIME < 0.2) | (TIME >= 0.23)
    for stamps in (np.round(TIME, 2)[kept], np.round(TIME[kept], 1)):
        with refused(ValueError):
            found({"time_s": stamps, "position": PLACE[kept], "command": VOLTS[kept]})


@pytest.mark.parametrize(
    ("unit", "turn", "begin"), [("rad", 2 * np.pi, 0), ("deg", 360, -180), ("turn", 1, 0)]
)
def test_what_goes_round_goes_on(unit, turn, begin):
    """Both ways, from 0 or from half a turn back; a reference that leads, or counts turns."""
    angle = 0.4 * turn + 2.0 * turn * np.sin(20 * TIME)
    wrapped, ahead = ((x - begin) % turn + begin for x in (angle, angle + 0.2 * turn))
    columns = {"time": TIME, "spindle_angle": wrapped, "command": VOLTS}
    for reference in (ahead, ahead[0] + angle - angle[0] + 7 * turn):
        told = columns | {"reference": reference}
        names = f"spindle_angle=spindle_angle [{unit}]", f"reference=reference [{unit}]"
        one = found(told, *names, drive=PLANTS["c-axis"])
        moved = 2 * np.pi / turn * (angle - angle[0])
        for name in ("spindle_angle", "reference"):
            off = one.values[name] - one.values[name][0]
            np.testing.assert_allclose(off, moved, atol=1e-9)
        lead = one.values["reference"][0] - one.values["spindle_angle"][0]
        assert abs(lead) <= np.pi
        assert any("spindle_angle wraps around" in note for note in one.notes)
    still = found({"time_s": TIME, "position": PLACE, "command": VOLTS, "reference": 9 * PLACE})
    assert still.notes == []  # what has lengths does not go round
    with refused(ValueError):
        bad = columns | {"spindle_angle": np.where(TIME == 0.2, 0.55, 0.1 * VOLTS) * turn}
        found(bad, names[0], drive=PLANTS["c-axis"])


def turned(angle, begin=0.0, turn=360.0):
    return (angle - begin) % turn + begin


def moved(*told, drive="c-axis", **columns):
    """The position of a log of an axis and its reference, each from its start."""
    log = {"time": TIME, "command": VOLTS} | columns
    one = found({x: y[np.isfinite(log["p"])] for x, y in log.items()}, *told, drive=PLANTS[drive])
    place = one.values[PLANTS[drive].seen[0]]
    return place - place[0], one


@pytest.mark.parametrize("begin", [0.0, -180.0])
def test_noise_where_an_angle_wraps_around_is_no_turn(begin):
    """It trembles about the wrap, and a filter has moved it beyond the range by the same noise."""
    noise = np.random.default_rng(2).normal(0.0, 0.05, TIME.shape)
    angle = begin + 40.0 * np.sin(20 * TIME) ** 3
    for wrapped in (turned(angle + noise, begin), turned(angle, begin) + noise):
        place, _ = moved("spindle_angle=p [deg]", p=wrapped)
        trembles = angle + noise
        np.testing.assert_allclose(place, np.radians(trembles - trembles[0]), atol=1e-9)


def test_counts_wrap_at_a_turn_or_at_the_number_that_is_told():
    """17 bits of a turn; 16 bits of 0.5 um in a straight line; an angle that is shown to 720."""
    angle = 3.0 * np.sin(8 * TIME)  # turns
    place, _ = moved(f"spindle_angle=p [{2**-17} turn]", p=np.round(2**17 * angle) % 2**17)
    np.testing.assert_allclose(place, 2 * np.pi * angle, atol=1e-4)
    counts = np.round(40_000 * angle) % 2**16 - 2**15
    place, one = moved("position=p [0.5 um] mod 65536", p=counts, drive="positioning-stage")
    np.testing.assert_allclose(place, 20 * angle, atol=1e-3)
    assert one.notes[-1].startswith("position wraps around (")
    place, _ = moved("spindle_angle=p [-1 deg] mod 720", p=turned(-360 * angle, 0.0, 720.0))
    np.testing.assert_allclose(place, 2 * np.pi * angle, atol=1e-9)
    for told, p in (("[deg]", turned(360 * angle, 0.0, 720.0)), ("[deg] mod 90", 360 * angle),
                    ("[deg] mod 0", angle), ("[deg] mod -90", angle)):  # fmt: skip
        with refused(ValueError) as why:
            moved(f"spindle_angle=p {told}", p=p)
        assert "mod" in why.refusal
    with refused(ValueError) as why:
        moved("spindle_angle=p [deg]", "command=u [V] mod 7", p=angle, u=VOLTS)
    assert why.where == "command"


def test_a_reference_wraps_where_the_position_does_not_and_a_step_of_a_turn_is_none():
    """It overtakes at 360 degrees a position that turns back just before; 1 mrad behind."""
    angle = 359.0 - 300.0 * np.cos(8 * TIME) ** 2
    ahead = angle + 2.0
    told = ("spindle_angle=p [deg]", "reference=r [deg]")
    _, one = moved(*told, p=angle, r=turned(ahead))
    np.testing.assert_allclose(one.values["reference"], np.radians(ahead), atol=1e-9)
    assert one.notes[-1].startswith("reference wraps around (")
    counted = 360.0 * np.sin(8 * TIME)  # the position counts turns, which its reference does not
    _, one = moved(*told, p=counted, r=turned(counted + 2.0))
    np.testing.assert_allclose(one.values["reference"], np.radians(counted + 2.0), atol=1e-9)
    step = 360.0 * (TIME > 0.05)
    follows = 360.0 * np.clip((TIME - 0.05) / 0.2, 0.0, 1.0)
    _, one = moved(*told, p=follows, r=step)
    np.testing.assert_allclose(one.values["reference"], np.radians(step))
    assert one.notes == []


def test_an_angle_goes_round_while_samples_are_missing():
    """At 0.2 turns in a sample, three are missing; then 50, during which it turns elsewhere."""
    angle = 72.0 * np.arange(400) + 10.0 * np.sin(TIME)
    place, one = moved(
        "spindle_angle=p [deg]",
        p=np.where(np.isin(np.arange(400), [100, 101, 102]), np.nan, turned(angle)),
    )
    np.testing.assert_allclose(place[103:], np.radians(angle - angle[0])[103:], atol=1e-9)
    assert (~one.usable).sum() == 3
    elsewhere = turned(angle + 170.0 * (TIME > 0.2))
    place, one = moved(
        "spindle_angle=p [deg]", p=np.where((TIME > 0.2) & (TIME < 0.25), np.nan, elsewhere)
    )
    np.testing.assert_allclose(place, np.radians(angle[:201] - angle[0]), atol=1e-9)


def test_a_long_gap_cuts_the_log():
    kept = (TIME < 0.1) | (TIME > 0.15)
    one = found({"time_s": TIME[kept], "position": PLACE[kept], "command": VOLTS[kept]})
    np.testing.assert_allclose(one.values["position"], PLACE[TIME > 0.15])
    assert "1 places" in one.notes[-1]
    kept = (TIME < 0.21) | (TIME > 0.26)  # with the gap, the part before it would not end in it
    one = found({"time_s": TIME[kept], "position": PLACE[kept], "command": VOLTS[kept]})
    np.testing.assert_allclose(one.values["position"], PLACE[TIME < 0.21])
    assert one.usable.all()
    breaks = np.zeros(400, bool)
    breaks[300] = True  # halsampler's overrun
    one = found({"position": PLACE, "command": VOLTS}, breaks=breaks, sample_time=1e-3)
    np.testing.assert_array_equal(one.values["command"], VOLTS[:300])


def test_what_is_cut_off_at_an_end_of_a_scale_is_left_out():
    cut = np.clip(PLACE, -2.0, 5.0)
    one = found({"time_s": TIME, "position": cut, "command": VOLTS})
    np.testing.assert_array_equal(one.usable, PLACE > -2.0)
    rests = np.clip(TIME, 0.0, 0.2)  # a ramp that ends: it may well rest there
    assert saturated(rests * (0.4 - rests)).sum() == 0


#: Columns and what is told of them.
BAD = [
    ("p u", []),
    ("time p q u", ["position=p [mm]", "position=q [mm]"]),
    ("time position still", ["command=still"]),
    ("back position command", ["time=back"]),
    ("still position command", ["time=still"]),
    ("time position command", ["position=q"]),
    ("time position command", ["speed=q"]),
    ("time p command", ["position=p [__import__]"]),
]


@pytest.mark.parametrize(("columns", "told"), BAD)
def test_what_cannot_be_used_is_refused_in_a_line(columns, told):
    named = {"time": TIME, "back": -TIME, "still": 2 + 0 * TIME, "position": PLACE, "p": PLACE}
    named |= {"command": VOLTS, "u": VOLTS, "q": PLACE, "Ist": PLACE}
    units = {"q": "q [mm]", "Ist": "Ist [um]"}
    with refused(ValueError) as one:
        found({units.get(name, name): named[name] for name in columns.split()}, *told)
    assert "\n" not in one.refusal


def test_a_clock_that_is_set_is_a_gap_and_not_billions_of_samples():
    """From 0 to seconds since 1970, which have seven digits behind the point."""
    stamps = TIME + 1.7e9 * (TIME > 0.0995)  # of 0.2 us each then
    one = found({"time_s": stamps, "position": PLACE, "command": VOLTS})
    np.testing.assert_allclose(one.values["position"], PLACE[100:])
    assert one.notes[0].endswith("is used, 1.7e+09 to 1.7e+09 s")
    assert one.sample_time == pytest.approx(1e-3, rel=1e-5)
    with refused(ValueError):
        found({"time_s": TIME, "position": PLACE, "command": VOLTS}, sample_time=1e-9)


def test_a_sample_time_is_as_short_a_number_as_the_stamps_allow():
    """What a control is made for is 0.5 ms; a period that is really another one stays."""
    time = 5e-4 * np.arange(4000)
    trembling = time + np.random.default_rng(3).normal(0.0, 2e-5, time.shape)
    trembling[0] = 0.0
    signal = np.sin(time)
    one = found({"time_s": trembling, "position": signal, "command": signal})
    assert one.sample_time == 5e-4
    slower = found({"time_s": trembling * 1.0001, "position": signal, "command": signal})
    assert slower.sample_time == pytest.approx(5.0005e-4, rel=2e-6)
    odd = found({"time_s": time / 5e-4 / 8192, "position": signal, "command": signal})
    assert odd.sample_time == pytest.approx(1 / 8192, rel=1e-6)


def test_of_very_many_samples_the_first_are_used(monkeypatch):
    monkeypatch.setattr(limits, "MOST", 150)
    one = found({"time_s": TIME, "position": PLACE, "command": VOLTS})
    np.testing.assert_allclose(one.values["position"], PLACE[:150])
    assert len(one.usable) == len(one.values["command"]) == 150
    assert one.notes == ["only the first 0.15 s are used (150 samples)"]


def test_a_last_step_of_an_encoder_before_a_rest_is_not_an_end_of_a_scale():
    """It is just a quarter of the usual four, but for its last bits, and it comes to rest."""
    for numbers in shaken(0.001, 0.1):
        step, start = numbers
        counts = np.concatenate([4 * np.arange(40), 157 + np.minimum(np.arange(30), 1)])
        assert not saturated(start + step * counts).any()


@pytest.mark.parametrize("bent", [0.02, 0.05, 0.1, 0.2, 0.3])
def test_a_peak_that_is_flat_by_the_steps_of_its_encoder_is_not_an_end_of_a_scale(bent):
    """Beside slow moves of a step or two in a sample, of which its last ones are as fast."""
    peak, slow = -0.5 * bent * (np.arange(41) - 20.3) ** 2, np.arange(-400.0, -100.0)
    turned = np.round(np.concatenate([slow, peak + 0.3]))
    assert (turned == turned.max()).sum() >= 4
    assert not saturated(turned).any()
    fast = np.minimum(np.arange(-300.0, 60.0, 4.0), 21.0)
    assert saturated(fast).sum() == (fast == 21.0).sum()


@pytest.mark.parametrize("off", [60.0, -0.5])
def test_a_wrong_sample_is_left_out_and_said(off):
    """Noise, steps of an encoder and reversals are none."""
    noise = np.random.default_rng(0).normal(0.0, 1e-3, len(PLACE))
    for place in (PLACE, PLACE + noise, 5e-3 * np.round(PLACE / 5e-3), np.abs(PLACE)):
        wrong = place + off * (np.arange(len(PLACE)) == 57)
        one, right = (
            found({"time": TIME, "position": x, "command": VOLTS}) for x in (wrong, place)
        )
        assert right.usable.all()
        assert np.flatnonzero(~one.usable).tolist() == [57]
        assert one.values["position"][57] == pytest.approx(place[57], abs=0.05)
        told = one.notes[-1].partition("the one at 0.057 s is ")[2].split()
        assert (float(told[0]), told[1]) == (pytest.approx(off, abs=0.05), "mm")


def test_a_column_that_the_user_names_is_the_signal():
    """Another one that is called like it is left alone."""
    columns = {"time_s": TIME, "position": PLACE, "position [um]": PLACE, "command": VOLTS}
    with refused(ValueError):
        found(columns)
    np.testing.assert_allclose(found(columns, "position=position").values["position"], PLACE)


def test_a_name_with_another_unit_than_the_drives_is_taken_by_itself_and_said():
    columns = {"time_ms": 1e3 * TIME, "position_um": 1e3 * PLACE, "voltage_mV": 1e3 * VOLTS}
    one = found(columns | {"velocity_m_s": 2e-3 * PLACE})
    np.testing.assert_allclose(one.values["position"], PLACE, atol=1e-12)
    np.testing.assert_allclose(one.values["command"], VOLTS, atol=1e-12)
    np.testing.assert_allclose(one.values["velocity"], 2.0 * PLACE, atol=1e-12)
    assert one.sample_time == pytest.approx(1e-3)
    for words in ("time is time_ms in ms", "position is position_um in um", "in mV", "in m/s"):
        assert words in one.notes[0]
    with refused(ValueError):
        found(columns | {"position_mm": PLACE})


def test_a_column_is_also_called_without_its_unit_and_may_be_of_another():
    columns = {"time [ms]": TIME, "Ist [mm]": PLACE, "command": VOLTS}
    one = found(columns, "time=time [s]", "position=Ist")
    np.testing.assert_allclose(one.values["position"], PLACE, atol=1e-12)
    assert one.sample_time == pytest.approx(1e-3)


def test_a_travel_that_some_machine_has_is_taken():
    """A stage of a microscope, a launcher of 300 m/s, a turbine of a million turns in a minute."""
    columns = {"time_s": TIME, "command": VOLTS}
    for place in (1e-6 * PLACE, 3e5 * TIME * (1.0 + TIME)):
        one = found(columns | {"position_mm": place})
        np.testing.assert_array_equal(one.values["position"], place)
    angle = 1e6 * 2.0 * np.pi / 60.0 * TIME * (1.0 + TIME)
    one = found(columns | {"spindle_angle": angle}, drive=PLANTS["c-axis"])
    np.testing.assert_array_equal(one.values["spindle_angle"], angle)


def test_five_samples_in_a_row_are_filled_in_and_with_six_missing_the_log_is_cut():
    for missing, steps, filled in ((5, 400, 5), (6, 300, 0)):
        kept = np.ones(400, bool)
        kept[300 : 300 + missing] = False
        one = found({"time_s": TIME[kept], "position": PLACE[kept], "command": VOLTS[kept]})
        assert len(one.usable) == steps
        assert (~one.usable).sum() == filled
