"""The scenario that ``hfc init`` begins with: a move of a plant, and what a good one is."""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.core.numbers import Plain
from hfc_design.core.records import UserError
from hfc_design.reference import entries as reference
from hfc_design.reference.commented import commented
from hfc_design.reference.entries import Entry

HIERARCHY = "pd+hierarchical-fuzzy"


class Move(NamedTuple):
    """A move from rest to rest in a unit of positions, and the error that is tolerated there."""

    distance: float
    velocity: float
    acceleration: float
    tolerance: float
    scale: float  # of the error for a fuzzy unit


MOVES = {
    "rad": Move(0.05, 0.1, 0.5, 1e-4, 3000.0),
    "deg": Move(20.0, 40.0, 200.0, 0.01, 20.0),
    "mm": Move(20.0, 40.0, 200.0, 0.01, 20.0),
    "BLU": Move(1000.0, 2000.0, 10000.0, 1.0, 0.1),
}
#: Of another unit, as an own plant may have it.
OTHER = Move(1.0, 1.0, 5.0, 1e-3, 100.0)
#: Time of a sample [s] of the controls that these plants are known with.
SAMPLES = {"feed-drive": 0.01, "milling-table": 0.005}
FIVE, ELSE = 0.002, 0.001


def beginning(plant: str, controller: str, own: Sequence[Entry] = ()) -> str:
    """A commented scenario as TOML; ``own`` are the entries of own parts.

    Raises:
        UserError: the controller needs keys that have no default.
    """
    every = reference.parts(reference.PLANT, plant, own)
    axes = next(one.meaning for one in every if one.key == "axes").split(", ")
    units, several = reference.units_of(plant, own), axes != ["one"]
    named = {reference.PLANT: plant, reference.REFERENCE: "per-axis" if several else "trapezoidal"}
    named |= {reference.OBJECTIVE: "tolerances", reference.CONTROLLER: controller}
    named |= {reference.STRATEGY: "cma" if controller == HIERARCHY else "l-shade"}
    live = _live(named, axes, every, units)
    known = reference.keys_of(named, own)
    needed = [
        one.key
        for one in known
        if one.required and one.key.startswith("controller.") and one.key.count(".") == 1
    ]
    if needed:
        raise UserError(
            f"--controller {controller}: needs {', '.join(needed)}, of which there is no default; "
            f"see hfc show controller {controller}"
        )
    head = (
        f"# A scenario for hfc design: the plant {plant} with a controller of kind {controller}.\n"
    )
    head += "# Take the # from #key = value to set a key; it stands there with its default.\n\n"
    return head + commented(live, known, units)


def _live(
    named: dict[str, str], axes: list[str], every: Sequence[Entry], units: dict[str, str]
) -> dict[str, Plain]:
    """The keys that people change first."""
    plant, controller = named[reference.PLANT], named[reference.CONTROLLER]
    several = axes != ["one"]
    move = MOVES.get(units.get("error", ""), OTHER)
    live: dict[str, Plain] = {
        "description": f"A move of {plant}",
        "plant.name": plant,
        "simulation.duration_s": 1.5,
        "simulation.sample_time_s": FIVE if several else SAMPLES.get(plant, ELSE),
        "fitness.kind": "tolerances",
        "fitness.settled_after_s": 0.9,
        "fitness.tolerances": {"rms_error": move.tolerance, "settled_rms_error": move.tolerance},
        "controller.kind": controller,
        "search.preset": named[reference.STRATEGY],
        "run.seed": 0,
    }
    if several:
        live |= {"reference.kind": "per-axis", "reference.axes": _axes(axes, every)}
    else:
        live |= {"reference.kind": "trapezoidal"}
        live |= {f"reference.{key}": x for key, x in _moved(move).items()}
    if controller == HIERARCHY:
        live["controller.inputs"] = [
            {"name": "error", "scale": move.scale},
            {"name": "reference_rate", "scale": 1.0 / move.velocity},
        ]
        live["controller.linear"] = {}
    return live


def _moved(move: Move) -> dict[str, Plain]:
    return {key: getattr(move, key) for key in ("distance", "velocity", "acceleration")}


def _axes(axes: list[str], every: Sequence[Entry]) -> dict[str, Plain]:
    """A move of each axis in its own unit."""
    units = {one.key: one.unit for one in every if one.part == "signal"}
    moves = {axis: MOVES.get(units.get(f"{axis}.error", ""), OTHER) for axis in axes}
    return {axis: {"kind": "trapezoidal", **_moved(move)} for axis, move in moves.items()}
