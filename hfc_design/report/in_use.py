"""Whether a design can be used, as its page tells it."""

from collections.abc import Sequence

from hfc_design.core.numbers import Json
from hfc_design.pictures.numbers import readable
from hfc_design.report.comparison.tables import NONE, short
from hfc_design.simulation.gain_range import gain_told
from hfc_design.simulation.in_use import TITLES, measured, merit_told
from hfc_design.simulation.missed import missed_told
from hfc_design.simulation.settling import EXPLAINED, reasons_told
from hfc_design.simulation.stressed import ABOUT, HEADS, broken, rows


def in_use(found: Json) -> Json:
    """What the page needs of the numbers of ``usable``."""
    each = found["motions"].items()
    sizes = zip(*(one["measures"].values() for _, one in each), strict=True)
    told = [_shown_in(*one) for one in zip(found["units"].values(), sizes, strict=False)]
    factors = [*(factor for factor, _ in told), 1.0]
    tracking = next(iter(found["units"]))
    titles = (TITLES.get(tracking, tracking), "chatter", "peak command")
    named = zip(titles, told, strict=True)
    heads = ["motion", "pass [%]", *(f"{name} [{unit}]" for name, (_, unit) in named)]
    return found | {
        "heads": [*heads, "share at a limit [1]"],
        "rows": [_row(name, one, factors) for name, one in each],
        "others": {name: why for name, one in each if (why := reasons_told(one["reasons"]))},
        "reasons": EXPLAINED,
        "alone": any(one.get("asked_of") == "nominal" for _, one in each),
        "gain_told": found["gain"] and gain_told(found["gain"]),
        "chaos_told": merit_told(found),
        "missed_told": missed_told(found.get("missed", {}), len(found["motions"])),
        "stress_heads": HEADS,
        "stress_rows": rows(found.get("stress", [])),
        "stress_broken": broken(found.get("stress", [])),
        "stress_about": ABOUT,
    }


def _shown_in(unit: str, measures: Sequence[Json]) -> tuple[float, str]:
    """Factor and unit in which the medians of a measure are read, one for all motions."""
    return readable(unit, min((abs(x) for one in measures if (x := one["median"])), default=1.0))


def _row(name: str, found: Json, factors: Sequence[float]) -> list[str]:
    """Name, share, and of each measure the median and the largest, times its factor."""
    cells = []
    for one, factor in zip(found["measures"].values(), factors, strict=True):
        pair = (one["median"], one["largest"])
        cells.append(" / ".join(measured(x, factor, short, NONE) for x in pair))
    mark = " *" if found.get("asked_of") == "nominal" else ""
    return [name + mark, f"{100 * found['share']:.4g}", *cells]
