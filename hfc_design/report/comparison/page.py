"""The page of a comparison: a self-contained file with curves to zoom into."""

from hfc_design.core.numbers import Json
from hfc_design.core.tables import Table
from hfc_design.plotting.files import small_address
from hfc_design.report import Page, rendered
from hfc_design.report.comparison import plots, tables, traces
from hfc_design.report.errors import errors
from hfc_design.simulation.comparison import SCORES, Comparison, MotionComparison
from hfc_design.simulation.stability_criteria import EXPLAINED

#: Largest number of panels below each other on a page.
PRINTED = 5


def page(comparison: Comparison, command: str = "") -> Page:
    """Return the page; equal comparisons give equal bytes. ``command`` repeats it in a shell."""
    names = list(comparison.designs)
    bouts = {bout.name: _shown(comparison, bout) for bout in comparison.bouts}
    motions = [bouts[bout.name] for bout in comparison.bouts if bout.scenario is not None]
    each = ((bout, *item) for bout in comparison.bouts for item in bout.meanings.items())
    meant = {tables.called(bout, key): text for bout, key, text in each if key not in SCORES}
    return rendered(
        "comparison.html.j2",
        "",
        small_address,
        f"{' and '.join(names)} in {', '.join(motion['name'] for motion in motions)}",
        names=names,
        machines=comparison.machines,
        within=comparison.within,
        seed=comparison.seed,
        failures=list(tables.failures(comparison)),
        reasons=EXPLAINED,
        together=[bouts[bout.name] for bout in comparison.bouts if bout.scenario is None],
        motions=motions,
        meant=meant.items(),
        machines_drawn=plots.machines(comparison),
        ratios=plots.ratios(comparison),
        count=len(comparison.differences),
        slices=traces.SLICES,
        notes=comparison.notes,
        designs=_origins(comparison),
        command=command,
        data=[motion["data"] for motion in motions],
    )


def _origins(comparison: Comparison) -> Table:
    """Return a table of the designs with their kinds and origins."""
    rows = [
        [name, design.controller.kind, str(design.provenance.get("source", "a search"))]
        for name, design in comparison.designs.items()
    ]
    about = "the compared designs, their kinds, and their origin."
    return Table(f"{' and '.join(comparison.designs)}: {about}", ["design", "kind", "from"], rows)


def _shown(comparison: Comparison, bout: MotionComparison) -> Json:
    """Return the content for a motion: tables; also curves, if it is not all motions together."""
    values: Json = {
        "name": bout.name,
        "metrics": tables.metric_table(comparison, bout),
        "differences": tables.difference_table(comparison, bout, bout.compared()[0]),
        "others": tables.other_differences(comparison, bout),
    }
    if bout.scenario is None:
        return values
    panels = traces.panels(bout)
    parts = (panels[k : k + PRINTED] for k in range(0, len(panels), PRINTED))
    return values | {
        "description": bout.scenario.description,
        "every": tables.metric_table(comparison, bout, every=True),
        "contour": plots.contours(bout),
        "errors": errors({name: one.motion for name, one in bout.results.items()}),
        "curves": [plots.motions(bout, part) for part in parts],
        "data": traces.data(bout, panels),
    }
