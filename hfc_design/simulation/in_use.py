"""What can be said about using a design: in each motion, in a line, as plain numbers."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Json, Mask
from hfc_design.core.shown import line, table
from hfc_design.core.statistics import share_interval
from hfc_design.simulation.monte_carlo import ENOUGH
from hfc_design.simulation.repeats import Repeats, chaos_told

#: What motions that never rest may not show.
UNSTABLE = (
    "at rest its linear loop swings by itself (hfc stability tells more, a motion that holds a "
    "position would show it)"
)

#: What no drive does, in whatever unit a table has it.
RUNAWAY = 1e9


class InMotion(NamedTuple):
    """What many machines do in one motion; the nominal one is not among them."""

    name: str
    good: Mask  # (machines,) stable, and within every constraint
    reasons: dict[str, int]  # why some are not -> how many
    told: dict[str, Floats]  # measure -> (machines,)
    nominal: dict[str, float]
    nominal_reasons: tuple[str, ...]  # none of a nominal machine that keeps everything
    bounds: dict[str, tuple[float, Floats]]  # constraint -> allowed, and (machines + 1,) measured
    everywhere: bool = True  # whether it is asked of all machines, and not of the nominal one alone


class Usable(NamedTuple):
    """What can be said about using a design."""

    spread: float
    seed: int
    motions: tuple[InMotion, ...]
    gain: tuple[float, float] | None  # factors on the command between which all is kept
    precision: float  # change of the merit from float32 to float64, as a share
    substeps: float | None  # the same to four times the substeps; None: not allowed
    units: dict[str, str]  # of the measures
    loop_stable: bool | None  # of the nominal machine at rest, where there is a linear loop
    repeats: Repeats  # of the merit of the nominal machine, in float64

    def __repr__(self) -> str:
        return line("Usable", self._told())

    def _repr_html_(self) -> str:
        each = {f"{one.name}: keep everything": float(one.good.mean()) for one in self.motions}
        return table(self.answer, self._told() | each)

    def _told(self) -> dict[str, object]:
        low, high = self.interval
        share = float(self.good.mean())
        told = {"yes": self.yes, "spread": self.spread, "machines": len(self.good)}
        return {**told, "share": share, "share_from": low, "share_to": high}

    @property
    def good(self) -> Mask:
        """(machines,) that keep everything in every motion."""
        return np.logical_and.reduce([one.good for one in self.asked])

    @property
    def asked(self) -> tuple[InMotion, ...]:
        """The motions that are asked of all machines."""
        return tuple(one for one in self.motions if one.everywhere)

    @property
    def interval(self) -> tuple[float, float]:
        """Of the share of such machines, by Clopper and Pearson."""
        return share_interval(int(self.good.sum()), len(self.good))

    @property
    def yes(self) -> bool:
        """Whether the nominal machine keeps everything, and nearly all of the others do."""
        calm = self.loop_stable is not False and not self._nominal
        return calm and bool(self.good.mean() >= ENOUGH)

    @property
    def _nominal(self) -> list[str]:
        """Why the nominal machine does not keep everything."""
        return [f"it {x} in {one.name}" for one in self.motions for x in one.nominal_reasons]

    @property
    def answer(self) -> str:
        """Yes, or no and why, in a line."""
        share, count = float(self.good.mean()), len(self.good)
        machines = f"{_percent(share)} of {count} unseen machines within +-{100 * self.spread:g} %"
        every = " in every motion" if len(self.motions) > 1 else ""
        if self.yes:
            return f"yes: {machines} keep everything{every}"
        if self.loop_stable is False and not self._nominal:
            return f"no: {UNSTABLE}; {machines} keep everything{every}"
        if why := self._nominal:
            more = f" and {len(why) - 1} more" if len(why) > 1 else ""
            return f"no: on the nominal machine {why[0]}{more}; {machines} keep everything{every}"
        worst = min(self.asked, key=lambda one: float(one.good.mean()))
        reason = max(worst.reasons, key=lambda why: worst.reasons[why])
        lost = f"{worst.reasons[reason]} {several(reason)}"
        if worst.reasons[reason] == 1:
            lost = f"1 {reason}"
        if not share:
            return f"no: no machine of {count} keeps everything; {lost} in {worst.name}"
        return f"no: only {machines} keep everything; {lost} in {worst.name}"

    def numbers(self) -> Json:
        """Everything as plain data; None where there is no number."""
        low, high = self.interval
        return {
            "usable": self.yes,
            "answer": self.answer,
            "spread": self.spread,
            "machines": len(self.good),
            "seed": self.seed,
            "share": float(self.good.mean()),
            "interval": [low, high],
            "loop_stable": self.loop_stable,
            "gain": None if self.gain is None else [*self.gain],
            "precision": _plain(self.precision),
            "substeps": None if self.substeps is None else _plain(self.substeps),
            "merit": _plain(float(self.repeats.values[0])),
            "repeats": self.repeats.numbers(),
            "chaotic": self.repeats.chaotic,
            "units": self.units,
            "motions": {one.name: _motion_numbers(one) for one in self.motions},
        }


def measured(value: float | None, factor: float, write: Callable[[float], str], none: str) -> str:
    """A measure times ``factor`` as a table has it; one that no drive has is of one that ran away.

    ``none`` stands for what was never finite.
    """
    if value is None:
        return none
    return "diverges" if abs(factor * value) >= RUNAWAY else write(factor * value)


def merit_told(found: Json) -> str:
    """Of ``Usable.numbers``: between what the merit is if it is chaotic, else nothing."""
    return chaos_told("merit", found["repeats"]) if found.get("chaotic") else ""


def several(reason: str) -> str:
    """What one machine does, as several do it."""
    verb, blank, rest = reason.partition(" ")
    return ("are" if verb == "is" else verb.removesuffix("s")) + blank + rest


def _percent(share: float) -> str:
    return f"{100 * share:.4g} %"


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _motion_numbers(one: InMotion) -> Json:
    told = one.told.items()
    measured = {name: _numbers(one.nominal[name], column) for name, column in told}
    bounds = {
        name: {"allowed": most, **_numbers(values[0], values[1:])}
        for name, (most, values) in one.bounds.items()
    }
    return {
        "share": float(one.good.mean()),
        "reasons": one.reasons,
        "nominal": list(one.nominal_reasons),
        "asked_of": "all" if one.everywhere else "nominal",
        "measures": measured,
        "constraints": bounds,
    }


def _numbers(nominal: float, values: Floats) -> dict[str, float | None]:
    finite = values[np.isfinite(values)]
    quantiles = np.quantile(finite, [0.5, 0.95, 1.0]).tolist() if len(finite) else [None] * 3
    own = {"nominal": _plain(nominal)}
    return own | dict(zip(("median", "q95", "largest"), quantiles, strict=True))
