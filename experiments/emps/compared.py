"""The designed controllers and their rivals, on the recorded motion and on others."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from experiments.emps.logs import GAIN, K_P, K_V, Log, following
from hfc_design.core.numbers import Json
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.comparison import Comparison, compare

HERE = Path(__file__).parent
SEARCH = HERE / "search.toml"
HIERARCHY = "hierarchy"
PUSHED = "recorded-with-pulses"
RECORDED, FORMULA = "recorded loop", "recorded gains, formula ahead"
#: What the tables call a design of the search -> its file.
SEARCHED = {
    HIERARCHY: "hierarchy.json",
    "lqi": "lqi.json",
    "pid+ff": "pid-ff.json",
    "recorded gains, ahead searched": "recorded-ff.json",
}
MACHINES = 200
#: Of the recorded motion: it comes again after 6.24 s.
SECONDS = 7.0


def _move(distance: float, velocity: float, acceleration: float) -> Json:
    numbers = {"distance": distance, "velocity": velocity, "acceleration": acceleration}
    return {"kind": "trapezoidal", **numbers}


class Part(NamedTuple):
    """A motion that no search had."""

    reference: Json
    seconds: float
    load: Json = {}


#: Of these a search had none.
MOTIONS = {
    "long": Part(_move(200.0, 120.0, 842.0), 2.5),
    "fast": Part(_move(-180.0, 300.0, 2000.0), 1.5),
    "slow-sine": Part({"kind": "sine", "amplitude": 5.0, "frequency_rad_s": 0.8}, 8.0),
    "fine": Part(_move(0.1, 0.3, 5.0), 1.0),
    "cut": Part(
        _move(30.0, 25.0, 400.0),
        2.0,
        {"constant": 20.0, "sines": [{"amplitude": 8.0, "frequency_rad_s": 40.0}]},
    ),
}


def fitted() -> dict[str, float]:
    """The parameters of the stage that the searches had."""
    return dict(load_scenario(str(SEARCH)).plant.parameters)


def by_formula() -> Design:
    """The recorded gains, and ahead of them what the fitted stage asks for: nothing searched.

    The mean of both directions, as there is one number for both.
    """
    stage = fitted()
    ahead = {
        "velocity": 1e-3 * stage["viscous_friction"] / GAIN,
        "acceleration": 1e-3 * stage["mass"] / GAIN,
        "coulomb": stage["coulomb_friction"] / GAIN,
        "coulomb_width": 0.5,  # [mm/s]
        "load": 1.0 / GAIN,
        "expected_load": stage["offset"],
    }
    changes = {"controller.kp": K_P, "controller.kd": K_V, "controller.signals": {}}
    return load_design("emps-cascade", {**changes, "controller.feed_forward": ahead})


def designs() -> dict[str, Design]:
    """Every controller by what the tables call it, the designed one first."""
    found = {name: load_design(str(HERE / file)) for name, file in SEARCHED.items()}
    return {**found, FORMULA: by_formula(), RECORDED: load_design("emps-cascade")}


def scenarios(logs: Sequence[Log], place: Path) -> Iterator[Scenario]:
    """All that is compared; with both logs also what follows them. Tables are put in ``place``."""
    whole = load_scenario(str(SEARCH))
    kept = whole.model_dump(mode="json", exclude_none=True, include={"plant", "sensors", "limits"})
    judged = {"fitness": {"kind": "tolerances"}, "controller": {"kind": "pid+ff"}}
    for name, part in MOTIONS.items():
        clock = {"duration_s": part.seconds, "sample_time_s": whole.simulation.sample_time_s}
        own = {"name": name, "reference": part.reference, "load": part.load, "simulation": clock}
        yield load_scenario({**kept, **judged, **own})
    if not logs:
        return
    first, second = (one.until(SECONDS) for one in logs)
    recorded: dict[str, Json] = {
        "recorded": {},
        "recorded-no-delay": {"limits": {**kept["limits"], "delay_samples": 0}},
        "recorded-observer": {
            "sensors": {**kept["sensors"], "velocity": "observer", "observer_hz": 150.0}
        },
        PUSHED: {"pulse": second.pulse},
    }
    recorded["recorded-observer"]["sensors"].pop("difference_samples")
    for name, changes in recorded.items():
        (own_place := place / name).mkdir()
        own = {**kept, "name": name, "parameters": {}, **changes}
        yield following(second if name == PUSHED else first, own_place, **own)


def compared(logs: Sequence[Log], place: Path, machines: int = MACHINES) -> Comparison:
    """Everybody in everything, on the same machines within the tolerances of the search."""
    robust = load_scenario(str(SEARCH)).robust
    assert robust is not None
    every = [*scenarios(logs, place)]
    return compare(designs(), every, robust.spread, machines, tolerances=robust.tolerances)


def rows(found: Comparison, metrics: Mapping[str, float]) -> Iterator[list[str]]:
    """Of each motion and design the stable share and what most machines do as well as.

    ``metrics`` are names and by how much they are multiplied.
    """
    for bout in found.bouts:
        for name, side in bout.sides.items():
            each = []
            for key, factor in metrics.items():
                if key not in side.values:  # of all motions together
                    each.append("")
                    continue
                own = (side.of_nominal(key), side.quantile(key, 0.5), side.quantile(key, 0.95))
                each.append(" / ".join("–" if x is None else f"{factor * x:.3g}" for x in own))
            yield [bout.name, name, f"{100 * side.stable.mean():.3g} %", *each]


def paired(found: Comparison, metric: str) -> Iterator[list[str]]:
    """On how many machines the hierarchy has less, and the median of the ratios."""
    for bout in found.bouts:
        cells = []
        for other in [*found.designs][1:]:
            pair = {HIERARCHY, other}
            one = next(x for x in found.of(bout.name, metric) if {x.first, x.second} == pair)
            low, high = one.ratio_interval or (None, None)
            ratio = "–" if low is None else f"{one.ratio:.3f} ({low:.3f} to {high:.3f})"
            cells.append(f"{one.better}, {ratio}")
        yield [bout.name, *cells]
