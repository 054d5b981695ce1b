"""The scenario that ``hfc init`` writes: a plant makes a move and has to reach goals."""

from collections.abc import Sequence
from typing import NamedTuple

from hfc_design.core.numbers import Plain
from hfc_design.core.records import UserError, option
from hfc_design.reference import entries as reference
from hfc_design.reference.commented import commented
from hfc_design.reference.entries import Entry

HIERARCHY = "pd+hierarchical-fuzzy"


class Move(NamedTuple):
    """A move from rest to rest, in units of the position, with the target of its error."""

    distance: float
    velocity: float
    acceleration: float
    target: float
    scale: float  # factor of the error at the input of a fuzzy unit

    def path(self) -> dict[str, float]:
        """Return key -> value for the trapezoidal reference of the move."""
        return {key: getattr(self, key) for key in ("distance", "velocity", "acceleration")}


MOVES = {  # by unit of the position, or by plant
    "rad": Move(0.05, 0.1, 0.5, 1e-4, 3000.0),
    "deg": Move(20.0, 40.0, 200.0, 0.01, 20.0),
    "mm": Move(20.0, 40.0, 200.0, 0.01, 20.0),
    "BLU": Move(1000.0, 2000.0, 10000.0, 1.0, 0.1),
    "milling-table": Move(4.0, 8.0, 40.0, 0.01, 20.0),  # no faster than 10 V drive it
}
#: Move in a unit that ``MOVES`` does not have, for example of a user's own plant.
OTHER = Move(1.0, 1.0, 5.0, 1e-3, 100.0)
#: Usual sample times [s] by plant; ``FIVE`` for several axes, ``ELSE`` for any other plant.
SAMPLES = {"feed-drive": 0.01, "milling-table": 0.005}
FIVE, ELSE = 0.002, 0.001
#: Plant -> usual sensors and limits: those of the scenarios c-axis-practical, five-axis-robust,
#: milling-table-robust and positioning-stage-move; a feed drive has its own encoder.
SENSED: dict[str, dict[str, Plain]] = {
    "c-axis": {
        "sensors.encoder_resolution": 3e-6,
        "sensors.noise": 1e-6,
        "sensors.velocity": "observer",
        "sensors.observer_hz": 80.0,
        "limits.command": 200.0,
        "limits.resolution": 0.05,
    },
    "feed-drive": {"sensors.velocity": "encoder", "limits.command": 127.0},
    "five-axis": {
        "sensors.noise": 2e-4,
        "sensors.velocity": "encoder",
        "limits.command": 8.0,
        "limits.delay_samples": 1.0,
    },
    "milling-table": {
        "sensors.velocity": "observer",
        "sensors.observer_hz": 40.0,
        "limits.command": 10.0,
    },
    "positioning-stage": {
        "sensors.encoder_resolution": 5e-5,
        "sensors.velocity": "encoder",
        "sensors.difference_samples": 2,
        "limits.command": 10.0,
    },
}
#: Tolerance of the parameters, and number of machines that a search simulates per candidate.
ROBUST: dict[str, Plain] = {
    "robust.spread": 0.2,
    **dict.fromkeys(("robust.first", "robust.machines", "robust.elite"), 8),
}
#: Constraints of every machine; in addition ``late_error``, as a multiple of the error's target.
CONSTRAINTS, LATE = {"limit_share": 0.05, "unsettled": 0.3}, 10.0


def beginning(plant: str, controller: str, added: Sequence[Entry] = ()) -> str:
    """Return a commented scenario as TOML; ``added`` has the entries of a user's own parts.

    Raises:
        UserError: the controller needs keys that have no default.
    """
    every = reference.parts(reference.PLANT, plant, added)
    axes = next(one.meaning for one in every if one.key == "axes").split(", ")
    units = reference.units_of(plant, added)
    named = {
        reference.PLANT: plant,
        reference.REFERENCE: "trapezoidal" if axes == ["one"] else "per-axis",
        reference.OBJECTIVE: "tolerances",
        reference.CONTROLLER: controller,
        reference.STRATEGY: "cma" if controller == HIERARCHY else "l-shade",
    }
    known = reference.keys_of(named, added)
    required = [one.key for one in known if one.required and one.key.startswith("controller.")]
    if needed := [key for key in required if key.count(".") == 1]:
        raise UserError(
            f"{option('controller', controller)}: needs {', '.join(needed)}, which has no default; "
            f"see hfc show controller {controller}"
        )
    of_axes = {one.key: one.unit for one in every if one.part == "signal"}
    live = _live(named, axes, of_axes, units)
    ideal = not any(key.startswith("sensors.") for key in live)
    some = "Without [sensors] and [limits] both are ideal; " if ideal else "Sensors, limits, "
    return (
        f"# A scenario for hfc design: the plant {plant} with a controller of kind "
        f"{controller}.\n# {some}[constraints] and [robust] are examples: put those of your "
        "machine in their place.\n# Remove the # of #key = value to set a key; the value shown is "
        "its default.\n\n"
    ) + commented(live, known, units)


def _live(
    named: dict[str, str], axes: list[str], of_axes: dict[str, str], units: dict[str, str]
) -> dict[str, Plain]:
    """Return the keys that are set, with values; ``of_axes``: signal of an axis -> unit."""
    plant, controller = named[reference.PLANT], named[reference.CONTROLLER]
    move = MOVES.get(plant) or MOVES.get(units.get("error", ""), OTHER)
    several = axes != ["one"]
    live: dict[str, Plain] = {
        "description": f"A move of {plant}",
        "plant.name": plant,
        "simulation.duration_s": 1.5,
        "simulation.sample_time_s": FIVE if several else SAMPLES.get(plant, ELSE),
        "fitness.kind": "tolerances",
        "fitness.settled_after_s": 0.9,
        "fitness.tolerances": {"rms_error": move.target, "settled_rms_error": move.target},
        "controller.kind": controller,
        "search.preset": named[reference.STRATEGY],
        "run.seed": 0,
        "reference.kind": named[reference.REFERENCE],
        **SENSED.get("five-axis" if plant.startswith("five-axis") else plant, {}),
        **ROBUST,
        "constraints": {**CONSTRAINTS, "late_error": LATE * move.target},
    }
    if several:  # a move of each axis in its own unit
        moves = {axis: MOVES.get(of_axes.get(f"{axis}.error", ""), OTHER) for axis in axes}
        live["reference.axes"] = {
            axis: {"kind": "trapezoidal", **move.path()} for axis, move in moves.items()
        }
    else:
        live |= {f"reference.{key}": x for key, x in move.path().items()}
    if controller == HIERARCHY:
        live["controller.inputs"] = [
            {"name": "error", "scale": move.scale},
            {"name": "reference_rate", "scale": 1.0 / move.velocity},
        ]
        live["controller.linear"] = {}
    return live
