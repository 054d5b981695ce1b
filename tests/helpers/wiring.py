"""A design's units once more, for the read-back tests of all formats of one unit a file.

``Unit.expected`` is LL eq. 3 and 4 and JK04 eq. 1 written out with exp and loops; ``command``
builds the controller from manifest.csv and controller.json as somebody would who has only these.
"""

import csv
import json
from math import exp, inf

import made_up
import numpy as np

from hfc_design.files.design import Design, named_design
from hfc_design.runtime import Controller

DESIGNS = [
    "lin-lee-1999-table-1",
    "lin-lee-1999-table-2",
    "jee-koren-2004-flc",
    "jee-koren-2004-aflc",
    "5x3",
    "2x11",
    "random-1",
    "random-2",
    "random-1-on-linear",
    "random-2-on-linear-scheduled",
    "random-3-on-linear-resonating",
    "random-4-on-linear-scheduled-resonating",
]
#: One of each sort of units; beside a linear part they are as without.
UNITS = [*DESIGNS[:1], *DESIGNS[2:7]]


def design(name):
    """A built-in design, or Table I with other rules, terms, scales and order of the units.

    Some have a linear part too, some of them a scheduled one, or resonators.
    """
    if name[0].isdigit():
        return made_up.named(10, *map(int, name.split("x")))
    if not name.startswith("random-"):
        return named_design(name)
    seed = int(name.split("-")[1])
    rng = np.random.default_rng(seed)
    data = named_design("lin-lee-1999-table-1").model_dump(mode="json")
    controller = data["controller"]
    controller["output_scale"] = rng.uniform(1.0, 100.0)
    for item in controller["inputs"]:
        item["scale"] = rng.uniform(0.1, 100.0)
    for term in controller["terms"]:
        term |= {"half_width": rng.uniform(0.0, 0.2), "rate": rng.uniform(2.0, 40.0)}
    for unit in controller["units"]:
        unit["consequents"] = rng.uniform(-1.5, 1.5, (7, 7)).tolist()
    if "linear" in name:
        controller["linear"] = made_up.linear_part(seed)
    if "scheduled" in name:
        controller["scheduled"] = made_up.scheduled_part(seed)
    found = Design.model_validate(data)
    return made_up.resonating(found, seed, 2.0, 900.0) if "resonating" in name else found


class Unit:
    """A unit of a design: what it reads and what it gives."""

    def __init__(self, record, k):
        controller = record.controller
        self.fuzzy = not hasattr(controller, "units")
        if self.fuzzy:
            names = controller.names
            self.name, self.column, self.row = names.output, names.error_change, names.error
            self.rows, self.columns = controller.error_terms, controller.error_change_terms
            self.table = controller.rules.centroids
        else:
            unit = controller.units[k]
            self.name = f"unit_{unit.id}"
            self.column, self.row = (
                name.replace("-", "_") for name in (unit.column_input, unit.row_input)
            )
            self.rows = self.columns = controller.terms
            self.table = unit.consequents

    def degree(self, term, u):
        if not self.fuzzy:
            return exp(-term.rate * max(abs(u - term.centre) - term.half_width, 0.0) ** 2)
        left = -inf if term.left is None else (u - term.left) / (term.centre - term.left)
        right = inf if term.right is None else (term.right - u) / (term.right - term.centre)
        rising = 1.0 if term.left is None else left
        falling = 1.0 if term.right is None else right
        return max(min(rising, falling, 1.0), 0.0)

    def expected(self, row, column, least=0.0):
        """The output, by those rules that fire at more than ``least``."""
        weighted = firing = 0.0
        columns = [self.degree(term, column) for term in self.columns]
        for term, singletons in zip(self.rows, self.table, strict=True):
            degree = self.degree(term, row)
            for other, singleton in zip(columns, singletons, strict=True):
                if degree * other > least:
                    weighted += degree * other * singleton
                    firing += degree * other
        return weighted / firing if firing else 0.0

    def points(self, count=2000):
        """(n, 2) row and column: random ones, every pair of centres, edges and what is beyond."""
        rng = np.random.default_rng(7)
        sides = []
        for terms in (self.rows, self.columns):
            marks = {0.0}
            for term in terms:
                edges = (term.left, term.right) if self.fuzzy else _shoulders(term)
                marks |= {term.centre, *(edge for edge in edges if edge is not None)}
            span = max(map(abs, marks)) if self.fuzzy else 1.0
            beyond = {1.5 * span, -1.5 * span}
            sides.append((sorted(marks | beyond), span))
        corners = [[r, c] for r in sides[0][0] for c in sides[1][0]]
        inside = 1.5 * rng.uniform(-1.0, 1.0, (count, 2)) * [span for _, span in sides]
        return np.array([*corners, *inside])


def _shoulders(term):
    return term.centre - term.half_width, term.centre + term.half_width


def units(record):
    return [Unit(record, k) for k in range(len(getattr(record.controller, "units", [0])))]


def entering(record, unit):
    """The unit's points; what an earlier unit gives is within its table or the universe."""
    points = unit.points()
    tables = {other.name: other.table for other in units(record)}
    for k, name in enumerate((unit.row, unit.column)):
        if name in tables:
            low, high = np.min(tables[name]), np.max(tables[name])
            points[:, k] = np.clip(points[:, k], min(low, -1.0), max(high, 1.0))
    return points


def clamped(unit, points):
    """The points as a unit counts them: a scaled signal beyond -1 .. 1 as these."""
    signal = [not unit.fuzzy and not name.startswith("unit_") for name in (unit.row, unit.column)]
    return np.where(signal, np.clip(points, -1.0, 1.0), points)


def unit_error(record, folder, suffix, evaluate, least=0.0, every=1):
    """Largest error of any unit, relative to its largest singleton if that is more than 1.

    ``evaluate(path, row, column, points)`` gives what the program does.
    """
    errors = []
    for unit in units(record):
        points = entering(record, unit)[::every]
        found = evaluate(folder / f"{unit.name}.{suffix}", unit.row, unit.column, points)
        wanted = [unit.expected(*point, least) for point in clamped(unit, points)]
        scale = max(1.0, np.abs(unit.table).max())
        errors.append(np.abs(found - np.array(wanted)).max() / scale)
    return max(errors)


def controller_error(record, folder, evaluate, samples=300):
    """Largest error of the command of the wired controller against ``runtime``, relative."""
    signals = random_signals(record, samples)
    found = command(folder, signals, evaluate)
    controller = Controller(not_adapting(record))
    wanted = [
        controller.step({name: float(v[k]) for name, v in signals.items()}) for k in range(samples)
    ]
    return np.abs(found - np.array(wanted)).max() / np.abs(wanted).max()


def not_adapting(record):
    data = record.model_dump(mode="json")
    if data["controller"]["kind"] in ("aflc", "soflc"):
        del data["controller"]["adaptation"]
        data["controller"] |= {"kind": "flc", "form": "PD"}
    return Design.model_validate(data)


def silent(rate=1e6):
    """Table I with terms so narrow that between them no rule fires."""
    data = named_design("lin-lee-1999-table-1").model_dump(mode="json")
    for term in data["controller"]["terms"]:
        term |= {"half_width": 0.0, "rate": rate}
    return Design.model_validate(data)


def random_signals(record, samples):
    """Signals up to 1.3 times what their scale sends to 1, or the outermost centre."""
    rng = np.random.default_rng(11)
    inputs = getattr(record.controller, "inputs", None)
    if inputs is None:
        velocity = 500.0 * rng.uniform(-1.0, 1.0, samples)
        signals = {"error": 25.0 * rng.uniform(-1.0, 1.0, samples)}
        return signals | ({"velocity": velocity} if record.controller.low_velocity else {})
    signals = {"error_rate": rng.uniform(-1.0, 1.0, samples)}
    for item in inputs:
        name = item.name.removeprefix("previous_")
        signals[name] = 1.3 / item.scale * rng.uniform(-1.0, 1.0, samples)
    for name in record.kind.reads(record.controller):
        if name not in signals:
            signals[name] = rng.uniform(-1.0, 1.0, samples)
    return signals


def command(folder, signals, evaluate):
    """The command at every sample, from the files alone."""
    about = json.loads((folder / "controller.json").read_text())
    found, change = _command(folder, about, signals, evaluate), about.get("largest_change", np.inf)
    before = 0.0
    for k, asked in enumerate(found):
        found[k] = before = min(max(asked, before - change), before + change)
    return found


def _command(folder, about, signals, evaluate):
    if "inputs" in about:
        values = {}
        for item in about["inputs"]:
            signal = signals[item["signal"]]
            if item["samples_ago"]:
                signal = np.concatenate([signal[:1], signal[:-1]])
            values[item["name"]] = np.clip(item["scale"] * signal, item["lowest"], item["highest"])
    else:
        error = signals["error"]
        change = 0.0 * error if about["form"] == "P" else np.diff(error, prepend=error[0])
        names = about.get("names", {"error": "error", "error_change": "error_change"})
        values = {names["error"]: error, names["error_change"]: change}
    with (folder / "manifest.csv").open() as file:
        for line in csv.DictReader(file):
            row, column = line["row_input"], line["column_input"]
            points = np.stack([values[row], values[column]], axis=1)
            values[line["unit"]] = evaluate(folder / line["file"], row, column, points)
    output, largest = values[about["output"]], about.get("largest_command", np.inf)
    if "inputs" in about:
        proportional = about["kp"] * signals["error"] + about["kd"] * signals["error_rate"]
        factor = about["output_scale"] * output
        if "scheduled" not in about:
            found = proportional + factor
        else:
            own = about["scheduled"]
            errors = own["kp"] * signals["error"] + own["kd"] * signals["error_rate"]
            found = proportional + factor * (errors + of_signals(own, signals))
        if "linear" in about:
            found = with_linear(found, about, signals, largest, factor)
        return np.clip(found, -largest, largest)
    low = about["low_velocity"]
    pushed = compensation(low, **signals) if low else np.zeros(len(output))
    steps = about["integral_gain"] * about["sample_time_s"] * signals["error"]
    integral = action = 0.0
    summed, found = about["form"] == "PI", []
    for inferred, step, push in zip(output, steps, pushed, strict=True):
        action = np.clip(action + inferred, -largest, largest) if summed else inferred
        whole = action + integral + step + push
        if not (abs(whole) > largest and step * whole > 0.0):
            integral += step
        found.append(np.clip(action + integral + push, -largest, largest))
    return np.array(found)


def of_signals(own, signals):
    """What a law adds to kp and kd, as the steps in controller.json say it."""
    whole = sum((gain * signals[name] for name, gain in own["signals"].items()), 0.0)
    whole = whole + own["velocity"] * signals["reference_rate"] + own["load"]
    whole += own["acceleration"] * signals["reference_acceleration"]
    direction = np.clip(signals["reference_rate"] / own["coulomb_width"], -1.0, 1.0)
    return whole + own["coulomb"] * direction


def with_linear(others, about, signals, largest, factor):
    """Commands of which ``others`` are the rest, as the steps in controller.json say it."""
    whole = others + of_signals(about["linear"], signals)
    every, own = about["sample_time_s"], about["linear"]
    other = about.get("scheduled", {"ki": 0.0})
    integral, found = 0.0, []
    turning = np.zeros((len(own.get("resonators", ())), 2))
    for rest, error, share in zip(whole, signals["error"], factor, strict=True):
        found.append(rest + integral + turning[:, 0].sum())
        beyond = found[-1] if abs(found[-1]) > largest else 0.0
        step = (own["ki"] + share * other["ki"]) * every * error
        integral += step if step * beyond <= 0.0 else 0.0
        for k, one in enumerate(own.get("resonators", ())):
            angle = every * one["frequency_rad_s"]
            gains = np.array([one["in_phase"], -one["quadrature"]])
            if "resonators" in other:
                further = other["resonators"][k]
                gains += share * np.array([further["in_phase"], -further["quadrature"]])
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            turning[k] = turn @ turning[k]
            if gains[0] * error * beyond <= 0.0:
                turning[k] += gains * every * error
    return np.array(found)


def compensation(low, velocity, error):
    """As the steps in controller.json say it (JK04 eq. 28-30)."""
    found = []
    for v, e in zip(low.get("blu_mm", 0.01) * velocity, error, strict=True):
        a, b, c = low["forward"] if v >= 0.0 else low["backward"]
        u = a * v**2 + b * v + c if abs(v) < low["highest_velocity_mm_s"] else 0.0
        if abs(v) < 0.5:
            ahead, back = low["breakaway"]
            small = low["smallest_error"]
            u = ahead if e >= small else back if e <= -small else 0.0
        found.append(u)
    return np.array(found)
