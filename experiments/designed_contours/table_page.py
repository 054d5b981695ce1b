"""The designed controller of the milling table beside the published ones, as tables.

python -m experiments.designed_contours.table_page            # the tables of the page, half an hour
"""

from pathlib import Path

import click
import numpy as np

from experiments.shared import markdown
from experiments.steps import Ranged, figures, finer
from hfc_design.cli.usage import Plain
from hfc_design.core.statistics import paired
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.comparison import DesignStatistics, compare

HERE = Path(__file__).parent
#: What is compared: metric -> what a table calls it.
METRICS = {
    "path_error_mm": "path error",
    "worst_glitch_mm": "impulse",
    "rms_contour_error_mm": "rms",
}
CHATTER = "rms_voltage_change_V"
OWN = "table"
CONTROLLERS = {name: HERE / f"{name}.json" for name in (OWN, "table-pid-ff", "table-expert-pid")}
PUBLISHED = ("huang-neural", "huang-soc", "huang-cross-coupled", "huang-pid")
OBSERVERS = ("sensors.velocity=observer", "sensors.observer_hz=40")
LARGE, SMALL = "milling-table-circle", "milling-table-small-circle"
FEED, SECONDS = "reference.feed_mm_min={}", "simulation.duration_s={}"
PART = (
    f"reference={{kind='gcode',file='{HERE / 'table-part.ngc'}',acceleration_mm_s2=20.0}}",
    SECONDS.format(29.5),
)
#: What the tables call it -> scenario, and what is changed of it.
MOTIONS: dict[str, tuple[str, tuple[str, ...]]] = {
    "circle-25-fast": (SMALL, (*OBSERVERS, FEED.format(418.9), SECONDS.format(23))),
    "circle-25-slow": (SMALL, (*OBSERVERS, FEED.format(104.7))),
    "circle-25-true-velocity": (SMALL, ()),
    "circle-25": (SMALL, OBSERVERS),
    "circle-60-fast": (LARGE, (*OBSERVERS, FEED.format(700), SECONDS.format(33))),
    "circle-60-true-velocity": (LARGE, ()),
    "circle-60": (LARGE, OBSERVERS),
    "part": (LARGE, (*OBSERVERS, *PART)),
}
SPREAD, MACHINES, SEED = 0.05, 200, 7
FRICTION = dict.fromkeys(("coulomb_friction", "stiction_rise", "motor_friction"), 0.3)
TOLERANCES = {"backlash": 0.5, **FRICTION}
NOMINAL = ("motion", "controller", *(f"{name} [um]" for name in METRICS.values()), "chatter [V]")
PAIRED = ("motion", "against", "stable", *METRICS.values())


def scenario(motion: str) -> Scenario:
    """What a motion is followed in."""
    return load_scenario(*MOTIONS[motion])


def row(motion: str, name: str, found: dict[str, Ranged], side: DesignStatistics) -> list[str]:
    """A controller on the nominal table; the comparison simulates it once more, in single floats.

    Where last bits decide, that gives another figure of the same range.
    """
    micron = Ranged.among([1e-3])
    each = [found[key].with_also(side.nominal[key]) for key in METRICS]
    own = (f"{one.over(micron):.1f}" for one in each)
    return [motion, name, *own, f"{found[CHATTER]:.2f}"]


def against(own: DesignStatistics, other: DesignStatistics, key: str) -> str:
    """On how many machines the first one has less, and the median of the ratios.

    Of the numbers alone: a design that oscillates has not lost by that.
    """
    mine, theirs = own.values[key], other.values[key]
    theirs = np.where(np.isnan(theirs), np.inf, theirs)  # diverged
    ratio, interval, _ = paired(np.log(mine) - np.log(theirs))
    low, high = interval or (np.nan, np.nan)
    return f"{(mine < theirs).sum()}, {ratio:.2f} ({low:.2f} to {high:.2f})"


def versus(motion: str, sides: dict[str, DesignStatistics]) -> list[list[str]]:
    """A row of each other controller: how the designed one differs, machine by machine."""
    own, rows = sides[OWN], []
    for name, side in sides.items():
        if name != OWN:
            kept = ", ".join(f"{100 * x.stable.mean():.3g} %" for x in (own, side))
            rows.append([motion, name, kept, *(against(own, side, key) for key in METRICS)])
    return rows


@click.command(cls=Plain)
@click.option("--machines", default=MACHINES, help="Beside the nominal one.")
@click.option("--motion", "wanted", multiple=True, type=click.Choice([*MOTIONS]))
@click.option("--finer", "times", default=1, help="Times the substeps, on these machines.")
def main(machines: int, wanted: tuple[str, ...], times: int) -> None:
    """Print the tables of the page."""
    own = CONTROLLERS | {name: name for name in PUBLISHED}
    designs = {name: load_design(str(source)) for name, source in own.items()}
    rows, pairs = [], []
    for motion in wanted or MOTIONS:
        where = scenario(motion)
        stepped = finer(where, times)
        told = compare(designs, stepped, SPREAD, machines, SEED, tolerances=TOLERANCES)
        sides = told.bouts[0].sides
        rows += [row(motion, x, figures(one, where), sides[x]) for x, one in designs.items()]
        pairs += versus(motion, sides)
    click.echo(markdown(NOMINAL, rows))
    click.echo(markdown(PAIRED, pairs))


if __name__ == "__main__":
    main()
