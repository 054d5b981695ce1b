"""What many machines do in one motion, as plain numbers."""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Json, Mask


class InMotion(NamedTuple):
    """What many machines do in one motion; the nominal one is not among them."""

    name: str
    good: Mask  # (machines,) stable, and within every constraint
    reasons: dict[str, int]  # why some are not -> how many
    told: dict[str, Floats]  # measure -> (machines,)
    nominal: dict[str, float]
    nominal_reasons: tuple[str, ...]  # none of a nominal machine that passes
    bounds: dict[str, tuple[float, Floats]]  # constraint -> allowed, and (machines + 1,) measured
    tolerances: dict[str, tuple[float, Floats]]  # the same of what the scenario's fitness tolerates
    everywhere: bool = True  # whether it is asked of all machines, and not of the nominal one alone

    def numbers(self) -> Json:
        """As plain data; None where there is no number."""
        each = self.told.items()
        bounds, tolerances = (
            {name: {"allowed": most, **_numbers(x[0], x[1:])} for name, (most, x) in own.items()}
            for own in (self.bounds, self.tolerances)
        )
        return {
            "share": float(self.good.mean()),
            "reasons": self.reasons,
            "nominal": list(self.nominal_reasons),
            "asked_of": "all" if self.everywhere else "nominal",
            "measures": {name: _numbers(self.nominal[name], column) for name, column in each},
            "constraints": bounds,
            "tolerances": tolerances,
        }


def plain(value: float) -> float | None:
    """A number for a file; None where it is none."""
    return float(value) if np.isfinite(value) else None


def _numbers(nominal: float, values: Floats) -> dict[str, float | None]:
    finite = values[np.isfinite(values)]
    quantiles = np.quantile(finite, [0.5, 0.95, 1.0]).tolist() if len(finite) else [None] * 3
    own = {"nominal": plain(nominal)}
    return own | dict(zip(("median", "q95", "largest"), quantiles, strict=True))
