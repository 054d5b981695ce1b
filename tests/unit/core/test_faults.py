"""Mistakes in every key of every built-in file: a line each, in plain words."""

import json
import time

import pytest
from plain_words import library_words, plain_lines

from hfc_design.core.faults import MOST
from hfc_design.core.records import UserError
from hfc_design.files.design import Design, builtin_designs, design_json, named_design, parse_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario

#: Of no type, or out of every range; one of them is wrong wherever it stands.
WRONG = (None, "mood", -1, 1e300, float("nan"), [], [[["a"]]], {}, {"mood": {"mood": 1}}, True)


def places(value, here=()):
    """Every place in tables, and in the first entry of lists."""
    if here:
        yield here
    if isinstance(value, dict):
        for key, part in value.items():
            yield from places(part, (*here, key))
    elif isinstance(value, list) and value:
        yield from places(value[0], (*here, 0))


def put(data, place, value):
    """The same with another value in a place."""
    if not place:
        return value
    own = put(data[place[0]] if len(place) > 1 else None, place[1:], value)
    if isinstance(data, dict):
        return data | {place[0]: own}
    return [own, *data[1:]]


def mistaken(data, own):
    """The file with a wrong value in one of its ``own`` places after the other."""
    for place in own:
        for wrong in WRONG:
            yield put(data, place, wrong)


def of_kinds(data, place):
    """A place and the kinds of the tables that hold it: a key of another kind is another."""
    kinds = []
    for key in place:
        kinds.append(data.get("kind") if isinstance(data, dict) else None)
        data = data[key]
    return place, *kinds


def with_own_places(files):
    """(file, places that none of those before has): each is tried in one file only."""
    known = set()
    for name, data in files:
        own = [place for place in places(data) if of_kinds(data, place) not in known]
        known.update(of_kinds(data, place) for place in own)
        if own:
            yield pytest.param(data, own, id=name)


def designs():
    for name in builtin_designs():
        yield name, json.loads(design_json(named_design(name))) | {"score": {}, "provenance": {}}


@pytest.mark.parametrize(("file", "own"), [*with_own_places(designs())])
def test_a_wrong_value_in_a_design_is_told_in_plain_words(file, own):
    refused = 0
    for data in mistaken(file, own):
        try:
            assert isinstance(parse_design(json.dumps(data), "mine.json"), Design)
        except UserError as error:
            plain_lines(error, "mine.json: ")
            refused += 1
    assert refused > 3 * len(own)


def refusal(call):
    """The lines of what a call refuses."""
    with pytest.raises(UserError) as refused:
        call()
    return plain_lines(refused.value)


def test_every_fault_of_a_file_has_a_line():
    changes = ["simulation.duration=3", "seed=1", "search.population=0", "reference.kind=ramps"]
    assert refusal(lambda: load_scenario("c-axis-ramp", changes)) == [
        "c-axis-ramp: simulation.duration = 3: there is no such key; did you mean duration_s? "
        "there is duration_s, sample_time_s, substeps",
        "c-axis-ramp: reference.kind = 'ramps': is no kind; did you mean ramp? there is ramp, "
        "sine, step, trapezoidal, csv, circle, line, polyline, gcode, per-axis",
        "c-axis-ramp: search.population = 0: has to be 1 or more",
        "c-axis-ramp: seed = 1: there is no such key; did you mean sensors.seed or run.seed? "
        f"there is {', '.join(Scenario.model_fields)}",
    ]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("simulation.duration_s=0", "simulation.duration_s = 0: has to be greater than 0 [s]"),
        ("run.seed=1.5", "run.seed = 1.5: has to be a whole number"),
        ("run.precision='float23'", "has to be 'float32' or 'float64'; did you mean 'float32'?"),
        ("search.population='many'", "search.population = 'many': has to be a whole number"),
        ("sensors.velocity='tacho'", "has to be 'tachometer', 'encoder' or 'observer'; did"),
        ("name='a b'", "name = 'a b': has to be 1 to 64 letters, digits, '.', '_' and '-'"),
        ("windows=[{name='A'}]", "windows.0.name = 'A': has to be 1 to 32 small letters"),
        ("start={velocity='x'}", "start.velocity = 'x': has to be a number or a table of keys"),
        ("reference={velocity=1}", "reference.kind: is missing; there is ramp, sine, step,"),
        ("limits.axes.x.comand=1", "limits.axes.x.comand = 1: there is no such key; did you mean"),
        ("limits.axes.x.command=-1", "limits.axes.x.command = -1: has to be greater than 0"),
        ("limits.axes.1x={}", "limits.axes.1x: its name has to be 1 to 32 letters, digits"),
        ("controller.kind=pidd", "controller.kind = 'pidd': is no controller known here; did you"),
        ("search.population=true", "search.population = True: has to be a whole number"),
        ("limits.command=true", "limits.command = True: has to be a number [V]"),
        ("plant.parameters.poles=true", "plant.parameters.poles = True: has to be a number"),
        ("start={velocity=true}", "start.velocity = True: has to be a number or a table of keys"),
        (
            "plant.parameters.stator_inductance='4.7 mH'",
            "stator_inductance = '4.7 mH': has to be a number [H], without the unit: 0.0047",
        ),
        (
            "sensors.axes.x.noise='1 mrad'",
            "sensors.axes.x.noise = '1 mrad': has to be a number [rad], without the unit: 0.001",
        ),
        ("simulation.duration_s='2 s'", "has to be a number [s], without the unit: 2"),
        ("limits.command='2 kg'", "limits.command = '2 kg': has to be a number [V]"),
        ("poles=2", "poles = 2: there is no such key; did you mean plant.parameters.poles? there"),
        ("fitness.tolerances={}", "there is no such key here, but with objective tolerances; "),
        ("robustness.spread=0.1", "; did you mean robust? there is name, "),
        (
            "plant.poles=2",
            "plant.poles = 2: there is no such key; did you mean plant.parameters.po",
        ),
        ("run.precision='FLOAT32'", "did you mean 'float32'?"),
        (
            "controller.kind='PID'",
            "controller.kind = 'PID': is no controller known here; did you m",
        ),
        ("constraints.max_eror=1", "is no measure; did you mean max_error? there is "),
        ("constraints.max_eror=1", " more; all are told by hfc show metric"),
        ("run.precision=1", "run.precision = 1: has to be 'float32' or 'float64'"),
        ("load.constant='x'", "load.constant = 'x': has to be a number [N m]"),
        ("search.preset=rase", "did you mean race? there is "),
        (
            "plant.parameters.spindle_mas=1",
            "spindle_mas: unknown; did you mean spindle_inertia? there is poles",
        ),
    ],
)
def test_rules_are_told_with_units_and_what_may_have_been_meant(change, line):
    (told,) = refusal(lambda: load_scenario("c-axis-ramp", [change]))
    assert line in told


def test_many_faults_are_counted():
    windows = [{"name": f"w{k}", "from_s": "x"} for k in range(MOST + 10)]
    lines = refusal(lambda: load_scenario("c-axis-ramp", {"windows": windows}))
    assert len(lines) == MOST + 1
    assert lines[-1] == "c-axis-ramp: and 10 more keys with faults, from windows.100.from_s on"


def test_a_text_for_a_parameter_hides_no_unknown_name_and_this_no_value():
    own = {"stiffness": "soft", "spindle_mas": 1, "poles": "x"}
    lines = refusal(lambda: load_scenario("c-axis-ramp", {"plant.parameters": own}))
    assert [line.partition(": ")[2].partition(":")[0] for line in lines] == [
        "plant.parameters.stiffness = 'soft'",
        "plant.parameters.poles = 'x'",
        "plant.parameters.spindle_mas",
    ]
    own = {"spindle_mas": 1, "gear_rato": 1, "stiffness": -1}
    lines = refusal(lambda: load_scenario("c-axis-ramp", {"plant.parameters": own}))
    assert "spindle_mas: unknown; did you mean spindle_inertia?" in lines[0]
    assert "gear_rato: unknown; did you mean gear_ratio?" in lines[1]
    assert lines[2].endswith("plant.parameters.stiffness = -1.0: has to be more than zero")


@pytest.mark.parametrize("table", [None, "simulation"])
def test_twenty_thousand_unknown_keys_take_no_minutes(table):
    unknown = {f"durations_{k}": 1.0 for k in range(20_000)}
    begun = time.process_time()
    data = {table: unknown} if table else unknown
    lines = refusal(lambda: load_scenario({"name": "x", **data}))
    assert time.process_time() - begun < 20.0  # were every one compared with every other: minutes
    assert len(lines) == MOST + 1
    assert "and 19900 more keys with faults" in lines[-1]


def test_what_is_quoted_stays_bounded_and_cannot_move_the_terminal():
    keys = {f"a\nb\x1b[2J{k}{'x' * 1000}": "\x1b[2J" * 1000 for k in range(MOST + 9)}
    lines = refusal(lambda: load_scenario({"name": "x"} | keys))
    assert len(lines) == MOST + 1


def test_words_of_the_library_would_be_found():
    assert library_words("x = 1: Extra inputs are not permitted")
    assert library_words(
        "Input tag 'foo' found using 'kind' does not match any of the expected tags: 'a'"
    )
    assert library_words("x = 0: Input should be greater than 0")
    assert library_words("String should match pattern '^a$'")
    assert not library_words("x = 0: has to be greater than 0 [s]")
