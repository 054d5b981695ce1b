"""The root that adapts: by hand, against a plain transcription, its bounds, the design file."""

import json

import feed_oracle
import numpy as np
import oracle
import pytest
from wording import refused

from hfc_design.controllers.hierarchical import root as root_unit
from hfc_design.controllers.hierarchical.root import Adaptation
from hfc_design.core.numbers import SCALARS
from hfc_design.files.design import Design, design_json, parse_design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runtime import Controller

ADAPTING = {"k_c": 1e-3, "largest_move": 2.0}
NS, PS, PM, PL = 2, 4, 5, 6


def adapting(name, **adaptation):
    """A built-in design with the record ``adaptation``, by way of its file."""
    data = json.loads(design_json(load_design(name)))
    data["controller"]["adaptation"] = adaptation
    return parse_design(json.dumps(data), "mine.json")


def one(place, *others):
    """Degrees of an input that belongs to one term alone, or to some alike."""
    return [1.0 if k in (place, *others) else 0.0 for k in range(7)]


def moved(samples, table, k_c=0.1, largest_move=1.0):
    """Moves (7, 7) of the consequents after ``samples`` of (in_error, in_column, in_row)."""
    memory = root_unit.initial_memory(0.0)
    for degrees in samples:
        in_error, *inputs = degrees
        law = Adaptation(k_c=k_c, largest_move=largest_move)
        found, memory = root_unit.step(SCALARS, law, memory, in_error, table, *inputs)
    np.testing.assert_allclose(found, np.array(table) + memory.moves, atol=1e-15)
    return np.array(memory.moves)


# JK04 Table 2 and Appendix B by hand: the only rule that fires is as large as the output.
@pytest.mark.parametrize(
    ("before", "now", "move"),
    [
        (PM, PM, +0.1),  # does not fall: p = -1, too small
        (PM, PL, +0.1),  # rises
        (PS, PL, +0.2),  # rises by two terms: p = -2
        (PL, PM, 0.0),  # falls
        (PM, 3, 0.0),  # into the middle
        (PM, NS, -0.1),  # to the other side: p = 1, too large
        (PS, 0, -0.1),
        (NS, NS, -0.1),  # the same with the other sign
        (NS, PM, +0.1),
        (3, PL, 0.0),  # a rule of the middle term is not considered
        (3, 0, 0.0),
    ],
)
def test_one_rule_by_hand(before, now, move):
    samples = [(one(before), one(4), one(1)), (one(now), one(6), one(6))]
    wanted = np.zeros((7, 7))
    wanted[1][4] = move
    np.testing.assert_allclose(moved(samples, [[0.5] * 7] * 7), wanted, atol=1e-15)


class Transcribed:
    """JK04's judgement on the root as loops and ifs; moves the table it is given."""

    def __init__(self, table, k_c, largest_move):
        self.first = [list(row) for row in table]
        self.now = [list(row) for row in table]
        self.k_c, self.largest = k_c, largest_move
        self.before = None

    def output(self, error, column, row):
        degrees = oracle.memberships(min(max(error, -1.0), 1.0))
        term = 3
        for k in (2, 4, 1, 5, 0, 6):
            if degrees[k] > degrees[term] + 1e-4:
                term = k
        if self.before is not None:
            self.judge(*self.before, term)
        self.before = term, oracle.memberships(column), oracle.memberships(row)
        return oracle.infer(self.now, column, row)

    def judge(self, before, in_column, in_row, term):
        p = feed_oracle.INDEX[before][term]
        if p == 0:
            return
        every = sum(in_row) * sum(in_column)
        fired = {}
        for i in range(7):
            for j in range(7):
                if in_row[i] * in_column[j] > every / 49:
                    fired[i, j] = in_row[i] * in_column[j]
        action = sum(w * self.now[i][j] for (i, j), w in fired.items()) / sum(fired.values())
        moves = {}
        for i, j in fired:
            _, sign = feed_oracle.verdict_jk04(before - 3, p, self.now[i][j], action)
            moves[i, j] = sign * self.k_c * abs(p)
        for (i, j), move in moves.items():
            low, high = self.first[i][j] - self.largest, self.first[i][j] + self.largest
            self.now[i][j] = min(max(self.now[i][j] + move, low), high)


def driven(count, seed):
    """Errors [rad], deflections [rad] and their rates [rad/s] of all sizes."""
    random = np.random.default_rng(seed)
    errors = np.array(feed_oracle.errors(count, seed)) * 1e-3
    others = 0.012 * np.sin(np.cumsum(random.uniform(0.0, 0.3, (2, count)), axis=1))
    return np.stack([errors, others[0], 4.0 * others[1]], axis=1).tolist()


def unit_of(names, table, **adaptation):
    """A design of one unit over two inputs, with a PD part of zero."""
    data = json.loads(design_json(load_design("lin-lee-1999-table-1")))
    controller = data["controller"]
    controller["pd"] = {"kp": 0.0, "kd": 0.0}
    controller["inputs"] = [item for item in controller["inputs"] if item["name"] in names]
    controller["units"] = [
        {"id": 0, "column_input": names[0], "row_input": names[1], "consequents": table.tolist()}
    ]
    controller["adaptation"] = adaptation
    return Design.model_validate(data)


@pytest.mark.parametrize(
    ("names", "adaptation", "scale"),
    [
        (("error", "deflection"), {"k_c": 0.01, "largest_move": 0.5}, 50.0),
        (("deflection", "error"), {"k_c": 0.2, "largest_move": 0.3}, 50.0),
        (
            ("deflection", "deflection_rate"),
            {"k_c": 0.02, "largest_move": 5.0, "error_scale": 80.0},
            80.0,
        ),
    ],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_equals_a_plain_transcription(names, adaptation, scale, seed):
    table = np.random.default_rng(seed).uniform(-0.1, 0.1, (7, 7))
    runtime = Controller(unit_of(names, table, **adaptation))
    plain = Transcribed(table, adaptation["k_c"], adaptation["largest_move"])
    for error, deflection, rate in driven(600, seed):
        signals = {"error": error, "deflection": deflection, "deflection_rate": rate}
        inputs = {"error": 50.0 * error, "deflection": 80.0 * deflection}
        inputs["deflection_rate"] = 20.0 * rate
        column, row = (min(max(inputs[name], -1.0), 1.0) for name in names)
        wanted = 10.0 * plain.output(scale * error, column, row)
        assert runtime.step(signals | {"error_rate": 0.0}) == pytest.approx(wanted, abs=1e-9)
    assert np.abs(np.array(plain.now) - table).max() > 0.1  # it did learn


def test_the_file_holds_only_what_is_there():
    assert "adaptation" not in design_json(load_design("lin-lee-1999-table-1"))
    for adaptation in (ADAPTING, ADAPTING | {"error_scale": 500.0}):
        design = adapting("lin-lee-1999-table-1", **adaptation)
        text = design_json(design)
        assert json.loads(text)["controller"]["adaptation"] == adaptation
        assert parse_design(text, "again.json") == design


@pytest.mark.parametrize(
    "adaptation",
    [
        {"k_c": 1e-4},
        {"k_c": 1e-4, "largest_move": 0.0},
        3.0,
    ],
)
def test_records_that_are_not_allowed(adaptation):
    data = json.loads(design_json(load_design("lin-lee-1999-table-1")))
    data["controller"]["adaptation"] = adaptation
    with refused() as found:
        parse_design(json.dumps(data), "mine.json")
    assert "mine.json: controller.adaptation" in found.refusal


def test_an_error_without_a_scale_is_refused():
    inputs = "controller.inputs=[{name='deflection',scale=80.0},{name='deflection_rate',scale=9.0}]"
    own = "controller.adaptation={k_c=1e-4,largest_move=1.0,error_scale=50.0}"
    assert load_scenario("c-axis-ramp", [inputs, own]).controller.adaptation is not None
    without = "controller.adaptation={k_c=1e-4,largest_move=1.0}"
    with refused() as found:
        load_scenario("c-axis-ramp", [inputs, without])
    assert "controller.adaptation.error_scale" in found.refusal
    table = np.zeros((7, 7))
    with pytest.raises(ValueError, match=r"adaptation\.error_scale"):
        unit_of(("deflection", "deflection_rate"), table, k_c=1e-4, largest_move=1.0)
