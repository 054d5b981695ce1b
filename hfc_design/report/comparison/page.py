"""The page of a comparison: one file that needs nothing else, with curves to zoom into."""

from typing import Any

from hfc_design.pictures.files import small_address
from hfc_design.report import Page, rendered
from hfc_design.report.comparison import tables, traces
from hfc_design.report.comparison.plots import contours, machines, motions, ratios
from hfc_design.report.errors import errors
from hfc_design.report.panels import Panel
from hfc_design.simulation.comparison import SCORES, Bout, Comparison
from hfc_design.simulation.settling import EXPLAINED

#: So many panels below each other fit on a page.
PRINTED = 5


def page(comparison: Comparison, command: str = "") -> Page:
    """The page; the same comparison gives the same bytes. ``command`` is what makes it again."""
    names = list(comparison.designs)
    moved = [bout for bout in comparison.bouts if bout.scenario is not None]
    shown = [traces.panels(bout) for bout in moved]
    data = [traces.data(bout, own) for bout, own in zip(moved, shown, strict=True)]
    each = ((bout, *item) for bout in comparison.bouts for item in bout.meanings.items())
    meant = {tables.called(bout, key): text for bout, key, text in each if key not in SCORES}
    return rendered(
        "comparison.html.j2",
        "",
        small_address,
        f"{' and '.join(names)} in {', '.join(bout.name for bout in moved)}",
        names=names,
        machines=comparison.machines,
        within=comparison.within,
        seed=comparison.seed,
        failures=list(tables.failures(comparison)),
        reasons=EXPLAINED,
        together=[_told(comparison, x) for x in comparison.bouts if x.scenario is None],
        motions=[_moved(comparison, *each) for each in zip(moved, shown, strict=True)],
        meant=[*meant.items()],
        machines_drawn=machines(comparison),
        ratios=ratios(comparison),
        head=tables.DIFFERENCE_HEAD,
        count=len(comparison.differences),
        slices=traces.SLICES,
        notes=comparison.notes,
        designs=[
            [name, design.controller.kind, str(design.provenance.get("source", "a search"))]
            for name, design in comparison.designs.items()
        ],
        command=command,
        data=data,
    )


def _told(comparison: Comparison, bout: Bout) -> dict[str, Any]:
    """Tables of a motion, or of all together."""
    main = bout.compared()[0]
    first = next(iter(comparison.designs))
    found = [x for x in comparison.differences if x.motion == bout.name]
    shown = [x for x in found if (x.metric, x.first) == (main, first)]
    return {
        "name": bout.name,
        "lines": tables.lines(bout),
        "metric": tables.called(bout, main),
        "differences": [[x.first, x.second, *tables.difference_row(x)] for x in shown],
        "others": [
            [x.first, x.second, tables.called(bout, x.metric), *tables.difference_row(x)]
            for x in found
            if x not in shown
        ],
    }


def _moved(comparison: Comparison, bout: Bout, shown: list[Panel]) -> dict[str, Any]:
    """What the page shows of a motion."""
    assert bout.scenario is not None
    return _told(comparison, bout) | {
        "description": bout.scenario.description,
        "every": tables.lines(bout, every=True),
        "contour": contours(bout),
        "errors": errors({name: one.motion for name, one in bout.found.items()}),
        "curves": [motions(bout, shown[k : k + PRINTED]) for k in range(0, len(shown), PRINTED)],
    }
