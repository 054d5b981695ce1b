"""A kind of controller of your own: a PD and a friction table over the speed, which it learns.

The table has seven points, which start at zero; active points learn from the error. The three gains
are searched, the table is saved (on the machine too), and the controller is exported to C.

In this folder::

    python 06_own_kind.py [GENERATIONS]
    hfc design c-axis-ramp-cutting --controller 06_own_kind:FrictionTable
"""

import sys
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

import hfc_design.api as hfc

POINTS = 7
HIGHEST = 0.04  # speed of the last point [rad/s]


class Gains(NamedTuple):
    """What is searched."""

    kp: Any  # [V/rad]
    kd: Any  # [V s/rad]
    rate: Any  # at which a point learns [V/(rad s)]


def start(law: hfc.AxisLaw, zero: Any) -> tuple[Any, ...]:
    """The table before the first sample, as the design has it."""
    return tuple(zero + height for height in law.structure)


def sample(xp: hfc.Xp, law: hfc.AxisLaw, gains: Gains, table: Any, signals: Any) -> Any:
    """One sample, in scalars: the simulator, the runtime and the search all step this text."""
    place = hfc.clipped(xp, 3.0 * signals["spindle_velocity"] / HIGHEST, -3.0, 3.0)
    weights = [xp.maximum(1.0 - abs(place - (k - 3.0)), 0.0) for k in range(POINTS)]
    friction = hfc.total(w * height for w, height in zip(weights, table, strict=True))
    pd = gains.kp * signals["error"] + gains.kd * signals["error_rate"]
    step = gains.rate * law.sample_time * signals["error"]
    # A command at its limit teaches nothing: the table would wind up.
    step = hfc.held(xp, law.limit, pd + friction, 0.0 * step, step)
    learnt = tuple(height + step * w for w, height in zip(weights, table, strict=True))
    return pd + friction, learnt, None


class FrictionTable(hfc.ControllerRecord):
    """The kind: its fields are what a design file holds."""

    kind: Literal["friction-table"] = "friction-table"
    summary = "PD beside a friction table over the speed, which it learns"
    settings = hfc.settings_of(Gains((100.0, 1e4), (30.0, 3e3), (1.0, 1e5)))
    genome = hfc.genome_of_gains
    kp: float
    kd: float
    rate: Annotated[float, Field(ge=0)]
    table: Annotated[tuple[float, ...], Field(min_length=POINTS, max_length=POINTS)] = (0.0,) * 7

    def law_gains(self) -> Gains:
        """Its numbers."""
        return Gains(self.kp, self.kd, self.rate)

    def law(self, limit: float | None) -> hfc.AxisLaw:
        """The law of one axis."""
        return hfc.AxisLaw(sample, start, self.sample_time_s, limit, self.table)

    def reads(self) -> list[str]:
        """Signals of a sample."""
        return ["error", "error_rate", "spindle_velocity"]

    @staticmethod
    def of_gains(gains: dict[str, float]) -> dict[str, Any]:
        """The keys of a file, of gains that a search has found."""
        return {**gains, "table": (0.0,) * POINTS}

    def adapted(self, learnt: Any) -> "FrictionTable":
        """The same with the table that it has learned."""
        return self.model_copy(update={"table": tuple(learnt)})


def main(generations: int = 30) -> None:
    """Search it and a PD alone under the cutting load, and write the better one in C."""
    hfc.register(FrictionTable)
    wanted = {"search.generations": generations, "search.population": 64, "limits.command": 60.0}
    for kind in ("pd", "friction-table"):
        changes = {**wanted, "controller": {"kind": kind}}
        result = hfc.design(hfc.load_scenario("c-axis-ramp-cutting", changes))
        metrics = result.evaluation.metrics
        print(f"{kind}: rms error {1e3 * metrics['rms_error_rad']:.3f} mrad")
    print(*sorted(path.name for path in hfc.export(result.design, "c", "friction_table").iterdir()))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
