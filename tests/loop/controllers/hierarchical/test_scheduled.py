"""A law that the root of a hierarchy multiplies: its command by hand, and what tells of it."""

import json

import made_up
import numpy as np
import pytest
from scheduled import changed, root, says
from sledge import hfc
from wording import refused, refused_command

from hfc_design import api
from hfc_design.controllers.hierarchical.units import SHARE, _universe, units_that_matter
from hfc_design.files.design import design_json, parse_design
from hfc_design.formats import FORMATS
from hfc_design.runtime import Controller


def law(part, told, kp, kd):
    """A linear law without its integral, term by term."""
    ahead = part.feed_forward
    direction = np.clip(told["reference_rate"] / (ahead.coulomb_width or 1.0), -1.0, 1.0)
    found = kp * told["error"] + kd * told["error_rate"]
    found += sum(gain * told[name] for name, gain in part.signals.items())
    found += ahead.velocity * told["reference_rate"] + ahead.coulomb * direction
    found += ahead.acceleration * told["reference_acceleration"]
    return found + ahead.load * ahead.expected_load


@pytest.mark.parametrize(("seed", "limit"), [(3, None), (5, 60.0), (7, 60.0)])
def test_the_command_by_hand(seed, limit):
    """linear(x) + output_scale root(inputs) scheduled(x); both integrals are one sum."""
    design = made_up.scheduling(seed)
    design = made_up.limited(design, limit) if limit else design
    own, every = design.controller, design.controller.sample_time_s
    names = list(design.kind.reads(own))
    assert set(own.scheduled.signals) <= set(names)
    rows = np.cumsum(np.random.default_rng(0).normal(0.0, 0.05, (200, len(names))), axis=0)
    controller, integral, before, held = Controller(design), 0.0, {}, 0
    for row in rows.tolist():
        told = dict(zip(names, row, strict=True))
        factor = own.output_scale * root(design, told, before or told)
        command = law(own.linear, told, own.pd.kp, own.pd.kd) + integral
        command += factor * law(own.scheduled, told, own.scheduled.kp, own.scheduled.kd)
        step = (own.linear.ki + factor * own.scheduled.ki) * every * told["error"]
        if limit and abs(command) > limit and step * command > 0.0:
            held += 1
        else:
            integral += step
        expected = np.clip(command, -limit, limit) if limit else command
        assert controller.step(told) == pytest.approx(expected, rel=1e-11, abs=1e-9)
        before = told
    assert bool(held) == bool(limit)


def test_a_root_of_nothing_leaves_the_linear_part_and_one_of_one_adds_the_law():
    """Of the same gains twice a root that always says 1 makes the command twice as large."""
    design = made_up.scheduling(7)
    data = design.model_dump(mode="json")["controller"]
    alike = data["linear"] | data["pd"]
    for value, factor in ((0.0, 1.0), (1.0, 2.0)):
        units = says(value, design)
        design = changed(design, scheduled=alike, units=units, output_scale=1.0)
        alone = changed(design, scheduled=None, output_scale=1e-300)
        random = np.random.default_rng(1)
        names = design.kind.reads(design.controller)
        one, other = Controller(design), Controller(alone)
        for row in random.normal(0.0, 0.1, (50, len(names))).tolist():
            told = dict(zip(names, row, strict=True))
            assert one.step(told) == pytest.approx(factor * other.step(told), rel=1e-12)


def test_a_reading_that_is_none_is_a_fault_and_leaves_the_memory():
    """Of every signal, those too that the scheduled law alone reads."""
    design = made_up.scheduling(9)
    own = design.controller
    names = list(design.kind.reads(own))
    inputs = {item.name.removeprefix("previous_") for item in own.inputs}
    assert set(own.scheduled.signals) - set(own.linear.signals) - inputs
    told = dict.fromkeys(names, 0.1)
    controller, undisturbed = Controller(design), Controller(design)
    assert controller.step(told) == undisturbed.step(told)
    for name in names:
        for odd in (np.nan, np.inf, -np.inf):
            assert np.isnan(controller.step(told | {name: odd}))
    assert controller._memory == undisturbed._memory
    assert controller.step(told) == undisturbed.step(told)
    controller.reset()
    assert controller.step(told) == Controller(design).step(told)


def explained(tmp_path, design, *arguments):
    (tmp_path / "design.json").write_text(design_json(design))
    names = design.kind.reads(design.controller)
    at = ",".join(f"{name}={0.01 * k:g}" for k, name in enumerate(names, 1))
    return hfc("explain", tmp_path / "design.json", "--at", at, "--at", at, *arguments).stdout


def test_the_shares_add_up_to_the_command_and_to_the_law(tmp_path):
    design = made_up.scheduling(7)
    own = design.controller
    found = json.loads(explained(tmp_path, design, "--json"))
    assert sum(found["parts"].values()) == pytest.approx(found["command"], rel=1e-12)
    told = found["signals"]
    scheduled = law(own.scheduled, told, own.scheduled.kp, own.scheduled.kd)
    assert sum(found["scheduled"].values()) == pytest.approx(scheduled, rel=1e-12)
    for name, gain in own.scheduled.signals.items():
        assert found["scheduled"][name] == pytest.approx(gain * told[name])
    assert found["parts"]["fuzzy"] == pytest.approx(
        10.0 * found["units"][-1]["output"] * scheduled, rel=1e-12
    )
    printed = explained(tmp_path, design)
    assert "scheduled law" in printed
    assert "value [V]" in printed
    assert "x 10 x scheduled law" in printed


@pytest.mark.parametrize(
    "change",
    [
        {"signals": {"torque": 1.0}},
        {"kp": "x"},
    ],
)
def test_a_file_that_is_none_is_told_in_a_line(change, tmp_path):
    data = json.loads(design_json(made_up.scheduling(7)))
    data["controller"]["scheduled"] = change
    (tmp_path / "mine.json").write_text(json.dumps(data))
    found = refused_command("score", tmp_path / "mine.json", "--scenario", "c-axis-ramp")
    assert len(found.splitlines()) == 1


def test_without_a_linear_part_it_is_refused():
    data = json.loads(design_json(made_up.scheduling(7)))
    del data["controller"]["linear"]
    with refused() as found:
        parse_design(json.dumps(data), "mine.json")
    assert "controller.scheduled" in found.refusal
    inputs = [{"name": name, "scale": 10.0} for name in ("error", "error_rate")]
    with refused() as found:
        api.load_scenario("c-axis-ramp", {"controller": {"inputs": inputs, "schedules": True}})
    assert "controller.schedules" in found.refusal


@pytest.mark.parametrize("name", ["fll", "fis"])
def test_a_file_of_rules_says_what_it_lacks(name, tmp_path):
    FORMATS[name].write(made_up.scheduling(7), tmp_path / "out")
    (first, *_) = sorted((tmp_path / "out").glob("unit_*"))
    assert "output multiplies a linear law" in first.read_text()
    about = json.loads((tmp_path / "out" / "controller.json").read_text())
    assert about["scheduled"]["reads"].keys() >= about["scheduled"]["signals"].keys()


def test_units_matter_by_what_they_do_to_the_whole_command():
    """Against the law one point at a time, of inputs that are all that is read."""
    names = ("error", "error_rate", "reference_rate")
    data = made_up.scheduling(7, 3).model_dump(mode="json")["controller"]
    text = json.dumps(data)
    for old, new in zip((item["name"] for item in data["inputs"]), names, strict=True):
        text = text.replace(f'"{old}"', f'"{new}"')
    data = json.loads(text)
    ahead = {"velocity": 700.0}
    data["linear"] = {"feed_forward": {"velocity": 40.0}}
    data["scheduled"] = {"kp": 90.0, "kd": -20.0, "feed_forward": ahead}
    counts = []
    for seed in range(3):
        random = np.random.default_rng(seed)
        for unit in data["units"]:
            table = random.uniform(-1.0, 1.0, (7, 7)) * 10.0 ** random.uniform(-3.0, 0.3)
            unit["consequents"] = table.tolist()
        design = changed(made_up.scheduling(7, 3), **data)
        counts.append(matter_by_hand(design))
        gains = design.controller.law_gains()
        assert units_that_matter(design.controller, population_of(gains)).tolist() == [counts[-1]]
    assert len(set(counts)) > 1


def matter_by_hand(design):
    own = design.controller
    points = _universe(len(own.inputs))[:, :, 0].T

    def commands(design):
        found = []
        for point in points:
            pairs = zip(own.inputs, point, strict=True)
            told = {item.name: u / item.scale for item, u in pairs}
            told["reference_acceleration"] = 0.0
            found.append(Controller(design).step(told))
        return np.array(found)

    whole, count = commands(design), 0
    for k in range(len(own.units)):
        tables = design.model_dump(mode="json")["controller"]["units"]
        mean = float(np.mean(tables[k]["consequents"]))
        tables[k]["consequents"] = np.full((7, 7), mean).tolist()
        off = whole - commands(changed(design, units=tables))
        count += np.sqrt(np.mean(off**2)) > SHARE * np.sqrt(np.mean(whole**2))
    return int(count)


def population_of(gains):
    """A population of one, its axis behind all others."""

    def one(value):
        if value is None or isinstance(value, float):
            return value if value is None else np.array([value])
        if hasattr(value, "_fields"):
            return type(value)(*map(one, value))
        return np.asarray(value)[..., None]

    return one(gains)
