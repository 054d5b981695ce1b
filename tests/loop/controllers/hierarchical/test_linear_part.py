"""A hierarchy on a linear part: its law by hand, what tells of it, what a search makes of it."""

import json

import made_up
import numpy as np
import pytest
from scheduled import on_linear
from wording import refused, refused_command

from hfc_design.controllers.genome import taken
from hfc_design.files.design import Design, design_json
from hfc_design.runs.individuals import genome_of
from hfc_design.runtime import Controller


def alone(design):
    """The same hierarchy beside its PD."""
    data = design.model_dump(mode="json")
    data["controller"].pop("linear")
    return Design.model_validate(data | {"limits": {}})


@pytest.mark.parametrize("limit", [None, 60.0])
def test_the_command_by_hand(limit):
    """PD and hierarchy as without a linear part; the rest, and when it is held, with NumPy."""
    design = made_up.hierarchy_on_linear(7)
    design = made_up.limited(design, limit) if limit else design
    own, every = design.controller.linear, design.controller.sample_time_s
    names = list(design.kind.reads(design.controller))
    random = np.random.default_rng(0)
    rows = np.cumsum(random.normal(0.0, 0.05, (300, len(names))), axis=0)
    controller, other, integral, held = Controller(design), Controller(alone(design)), 0.0, 0
    for row in rows.tolist():
        told = dict(zip(names, row, strict=True))
        ahead = own.feed_forward
        direction = min(max(told["reference_rate"] / ahead.coulomb_width, -1.0), 1.0)
        command = other.step(told) + integral
        command += sum(gain * told[name] for name, gain in own.signals.items())
        command += ahead.velocity * told["reference_rate"] + ahead.coulomb * direction
        command += ahead.acceleration * told["reference_acceleration"]
        command += ahead.load * ahead.expected_load
        step = own.ki * every * told["error"]
        if limit and abs(command) > limit and step * command > 0.0:
            held += 1
        else:
            integral += step
        expected = np.clip(command, -limit, limit) if limit else command
        assert controller.step(told) == pytest.approx(expected, rel=1e-12, abs=1e-9)
    assert bool(held) == bool(limit)


@pytest.mark.parametrize(
    ("key", "part"),
    [
        ("signals", {"signals": ["deflection_rate", "rotor_velocity"]}),
        ("ranges.kp", {"ranges": {"kp": [1, 2]}}),
        ("tolerances", {"tolerances": {"error": 1.0}}),
        ("coulomb_width", {"coulomb_width": 0.0}),
    ],
)
def test_settings_that_cannot_be_searched_are_told_by_their_key(key, part):
    with refused() as found:
        genome_of(on_linear(part=part))
    assert f"controller.linear.{key}" in found.refusal
    assert "\n" not in found.refusal


@pytest.mark.parametrize(
    "change",
    [
        {"signals": {"torque": 1.0}},
        {"feed_forward": {"coulomb": 1.0}},
        {"feed_forward": {"load": "x"}},
    ],
)
def test_a_file_that_is_none_is_told_in_a_line(change, tmp_path):
    data = json.loads(design_json(made_up.hierarchy_on_linear(7)))
    data["controller"]["linear"] = change
    (tmp_path / "mine.json").write_text(json.dumps(data))
    found = refused_command("score", tmp_path / "mine.json", "--scenario", "c-axis-ramp")
    assert len(found.splitlines()) == 1


def test_the_paper_s_algorithm_searches_a_pd_alone():
    with refused() as found:
        on_linear(**{"search.preset": "lin-lee-1999"})
    assert "search.preset" in found.refusal


def test_what_the_population_does_the_design_file_does():
    """The load that is expected too, which the file holds as gain times load."""
    own = {"expected_load": 5.0, "load_frequencies_rad_s": [1.0, 50.0]}
    own |= {"notch": True, "lowpass": True}
    genome = genome_of(on_linear("c-axis-ramp-cutting", own))
    found = genome.fresh(np.zeros(4, int), np.random.default_rng(1))
    gains = genome.gains(found).linear
    for k in range(4):
        record = genome.record(taken(found, slice(k, k + 1)))
        own = Design.model_validate(
            {
                "name": "one",
                "plant": {"name": "c-axis", "parameters": {}},
                "controller": {**record, "sample_time_s": 0.001},
            }
        ).controller
        for name, value in own.linear_part.law_gains()._asdict().items():
            np.testing.assert_allclose(
                np.ravel(value), np.ravel(np.asarray(getattr(gains, name))[..., k]), rtol=1e-12
            )
    assert gains.load[0] != 0.0


def test_a_blend_beyond_its_ends_is_a_design():
    """Of a width of 1 and one of 2 mrad/s, a quarter and more beyond: none is 0 or below it."""
    genome = genome_of(on_linear("c-axis-ramp-cutting", {}))
    found = genome.fresh(np.zeros(9, int), np.random.default_rng(1))
    width = genome.ends[-1] + 3
    ends = []
    for value in (1e-3, 2e-3):
        linear = found.linear.copy()
        linear[:, width] = value
        ends.append(found._replace(linear=linear))
    blended = genome.blended(*ends, np.linspace(-2.0, 2.0, 9))
    expected = np.maximum(1e-3 + 1e-3 * np.linspace(-2.0, 2.0, 9), 1e-5)
    np.testing.assert_allclose(blended.linear[:, width], expected)
    for k in range(9):
        record = {**genome.record(taken(blended, slice(k, k + 1))), "sample_time_s": 0.001}
        plant = {"name": "c-axis", "parameters": {}}
        Design.model_validate({"name": "one", "plant": plant, "controller": record})


def test_a_signal_may_be_an_input_too():
    data = json.loads(design_json(made_up.hierarchy_on_linear(7)))
    data["controller"]["linear"]["signals"] = {"spindle_velocity": 2.0}
    both = Design.model_validate(data)
    assert both.kind.reads(both.controller).count("spindle_velocity") == 1
