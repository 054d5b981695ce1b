"""What can be said about using a design: in each motion, in a line, as plain numbers."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Json, Mask
from hfc_design.core.shown import line, table
from hfc_design.core.statistics import share_interval
from hfc_design.simulation.missed import missed, missed_told
from hfc_design.simulation.monte_carlo import ENOUGH
from hfc_design.simulation.one_motion import InMotion, plain
from hfc_design.simulation.repeats import Repeats, chaos_told
from hfc_design.simulation.settling import several
from hfc_design.simulation.stressed import NO, ON_THIS_MODEL, YES, Stressed, breaking
from hfc_design.stability.report import LoopMargins

#: What motions that never rest may not show.
UNSTABLE = (
    "the loop is unstable at rest or at speed (see hfc stability; a motion that holds that would "
    "show it)"
)

#: What measures of tracking are called.
TITLES = {
    "settled_rms_error": "settled rms error",
    "estimated_rms_contour_error": "estimated rms contour error",
}
NOTHING: Mapping[str, float] = MappingProxyType({})
#: What no drive does, in whatever unit a table has it.
RUNAWAY = 1e9


class Usable(NamedTuple):
    """What can be said about using a design."""

    spread: float
    seed: int
    motions: tuple[InMotion, ...]
    gain: (
        tuple[float, float] | None
    )  # factors on the command between which the nominal machine passes
    precision: float  # change of the merit from float32 to float64, as a share
    substeps: float | None  # the same to four times the substeps; None: not allowed
    units: dict[str, str]  # of the measures
    margins: LoopMargins | None  # None: the loop cannot be linearised
    repeats: Repeats  # of the merit of the nominal machine, in float64
    stress: tuple[Stressed, ...] = ()  # what was tried beside the scenario's machines
    why_not: Json | None = None  # of no: what would give a yes
    asked: Mapping[str, float] = NOTHING  # what the margins have to be

    def __repr__(self) -> str:
        return line("Usable", self._told())

    def _repr_html_(self) -> str:
        each = {f"{one.name}: pass": float(one.good.mean()) for one in self.motions}
        return table(self.answer, self._told() | each)

    def _told(self) -> dict[str, object]:
        low, high = self.interval
        share = float(self.good.mean())
        told = {"yes": self.yes, "spread": self.spread, "machines": len(self.good)}
        found = {**told, "share": share, "share_from": low, "share_to": high}
        return found | ({"misses": missed_told(self.missed)} if self.missed else {})

    @property
    def good(self) -> Mask:
        """(machines,) that pass every motion: stable, and every constraint met."""
        return np.logical_and.reduce([one.good for one in self._everywhere])

    @property
    def _everywhere(self) -> tuple[InMotion, ...]:
        """The motions that are asked of all machines."""
        return tuple(one for one in self.motions if one.everywhere)

    @property
    def interval(self) -> tuple[float, float]:
        """Of the share of such machines, by Clopper and Pearson."""
        return share_interval(int(self.good.sum()), len(self.good))

    @property
    def yes(self) -> bool:
        """Whether that holds on a machine that is not quite the model, too."""
        return self.verdict == YES

    @property
    def verdict(self) -> str:
        """Whether the nominal machine passes every motion, nearly all others do, and stress too."""
        calm = self.loop_stable is not False and not self._nominal and not self.short_of
        if not (calm and self.good.mean() >= ENOUGH):
            return NO
        return YES if all(one.holds for one in self.stress) else ON_THIS_MODEL

    @property
    def loop_stable(self) -> bool | None:
        """Whether that of the nominal machine is, where it is slowest and fastest."""
        return self.margins and self.margins.stable

    @property
    def short_of(self) -> list[str]:
        """What the margins lack of what is asked, in words."""
        return self.margins.broken(self.asked) if self.margins else []

    @property
    def missed(self) -> Json:
        """Measure -> how many times the scenario's own tolerance, and in which motion it is most.

        Of the median machine, and of the nominal one in a motion that is asked of it alone; what
        keeps its tolerance is left out.
        """
        return missed({one.name: one.numbers() for one in self.motions})

    @property
    def _nominal(self) -> str:
        """Why the nominal machine does not pass; "" if it does."""
        bad = [one for one in self.motions if one.nominal_reasons]
        if not bad:
            return ""
        others = f" and fails in {len(bad) - 1} more motions" if len(bad) > 1 else ""
        others = others.removesuffix("s") if len(bad) == 2 else others
        return f"{' and '.join(bad[0].nominal_reasons)} in {bad[0].name}{others}"

    @property
    def answer(self) -> str:
        """Yes, on this model only, or no, and why, in a line."""
        share, count = float(self.good.mean()), len(self.good)
        machines = f"{_percent(share)} of {count} unseen machines within +-{100 * self.spread:g} %"
        passes = "pass every motion" if len(self.motions) > 1 else "pass"
        passes += " required of them" if len(self._everywhere) < len(self.motions) else ""
        if self.verdict != NO:
            broken = breaking(self.stress)
            return f"{self.verdict}: {machines} {passes}" + (broken and f"; {broken}")
        if self.loop_stable is False and not self._nominal:
            return f"no: {UNSTABLE}; {machines} {passes}"
        if why := self._nominal:
            return f"no: the nominal machine {why}; {machines} {passes}"
        if short := self.short_of:
            return f"no: {', '.join(short)}; {machines} {passes}"
        worst = min(self._everywhere, key=lambda one: float(one.good.mean()))
        reason = max(worst.reasons, key=lambda why: worst.reasons[why])
        lost = f"{worst.reasons[reason]} {several(reason)}"
        if worst.reasons[reason] == 1:
            lost = f"1 {reason}"
        if not share:
            return f"no: none of {count} unseen machines passes; {lost} in {worst.name}"
        return f"no: only {machines} {passes}; {lost} in {worst.name}"

    def numbers(self) -> Json:
        """Everything as plain data; None where there is no number."""
        low, high = self.interval
        return {
            "usable": self.yes,
            "verdict": self.verdict,
            "answer": self.answer,
            "missed": self.missed,
            "spread": self.spread,
            "machines": len(self.good),
            "seed": self.seed,
            "share": float(self.good.mean()),
            "interval": [low, high],
            "loop_stable": self.loop_stable,
            "margins": self.margins and self.margins.numbers(),
            "gain": None if self.gain is None else [*self.gain],
            "precision": plain(self.precision),
            "substeps": None if self.substeps is None else plain(self.substeps),
            "merit": plain(float(self.repeats.values[0])),
            "repeats": self.repeats.numbers(),
            "chaotic": self.repeats.chaotic,
            "why_not": self.why_not,
            "stress": [one.numbers() for one in self.stress],
            "units": self.units,
            "motions": {one.name: one.numbers() for one in self.motions},
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


def _percent(share: float) -> str:
    return f"{100 * share:.4g} %"
