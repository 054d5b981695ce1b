"""The controller that hfc design five-axis-robust ends with, on programs that it was not made on.

python -m experiments.designed_contours.five_axes             # the tables of the page, some minutes
"""

from collections.abc import Iterator, Mapping
from pathlib import Path

import click

from experiments.shared import markdown
from experiments.steps import Ranged, figures, finer
from hfc_design.cli.usage import Plain
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.plotting.files import save
from hfc_design.report.comparison.plots import machines as drawn
from hfc_design.simulation.comparison import Comparison, compare

HERE = Path(__file__).parent
DESIGNED = "designed"
#: On the nominal machine alone.
WHOLE = "blade, whole"
#: What each controller is called -> its design.
CONTROLLERS = {
    DESIGNED: HERE / "five_axes.json",
    "PID with feed-forward, by rule": HERE / "five_axes_pid_ff.json",
    "PID of 2009": "lin-gai-2009-pid",
    "fuzzy sliding of 2009": "lin-gai-2009-fuzzy-sliding",
    "compensated of 2009": "lin-gai-2009-fuzzy-sliding-compensated",
}
SLOW = f"reference.file={HERE / 'five_axes_slow.ngc'}"
COUPLED = "plant.name=five-axis-coupled"
SECONDS = "simulation.duration_s={}"
#: What the tables call it -> scenario, what is changed of it, and of every design.
PROGRAMS: dict[str, tuple[str, tuple[str, ...], dict[str, str]]] = {
    "program of 2009": ("five-axis-program", (), {}),
    "as printed": ("five-axis-program-printed", (), {}),
    "blade, 6 s": ("five-axis-blade", (SECONDS.format(6),), {}),
    "blade at F900, 6 s": ("five-axis-blade", (SLOW, SECONDS.format(6)), {}),
    "coupled axes": ("five-axis-program", (COUPLED,), {"plant.name": COUPLED[11:]}),
    WHOLE: ("five-axis-blade", (), {}),
}
#: Metric -> what a table calls it.
MEASURED = {
    "rms_contour_error_mm": "contour, rms [µm]",
    "max_contour_error_mm": "largest [µm]",
    "cutting_max_contour_error_mm": "without rapids [µm]",
    "worst_glitch_mm": "at reversals [µm]",
    "rms_orientation_error_deg": "orientation, rms [mdeg]",
    "max_orientation_error_deg": "largest [mdeg]",
}
CHATTER, OVERSHOOT = "rms_voltage_change_V", "_overshoot_"
SPREAD, MACHINES = 0.3, 200


def designs(program: str) -> dict[str, Design]:
    """Every controller on the machine of a program, by what the tables call it."""
    changes = PROGRAMS[program][2]
    return {name: load_design(str(source), changes) for name, source in CONTROLLERS.items()}


def scenario(program: str) -> Scenario:
    """What a program is followed in."""
    name, changes, _ = PROGRAMS[program]
    return load_scenario(name, changes)


def row(program: str, name: str, found: Mapping[str, Ranged]) -> list[str]:
    """A controller on the nominal machine."""
    beyond = max(x for key, x in found.items() if OVERSHOOT in key)
    own = [*(found[key] for key in MEASURED), beyond, found[CHATTER]]
    return [program, name, *(f"{x.over(Ranged.among([1e-3])):.3g}" for x in own)]


def paired(program: str, found: Comparison) -> Iterator[list[str]]:
    """A row of each other controller: how the designed one differs, machine by machine."""
    sides, motion = found.bouts[0].sides, found.differences[0].motion
    for other in list(CONTROLLERS)[1:]:
        each = [found.of(motion, key) for key in MEASURED]
        two = [next(x for x in own if {x.first, x.second} == {DESIGNED, other}) for own in each]
        stable = (f"{int(sides[name].stable.sum())}" for name in (DESIGNED, other))
        cells = [f"{one.ratio:.3f} ({one.better})" for one in two]
        yield [program, other, *cells, " / ".join(stable)]


@click.command(cls=Plain)
@click.option("--machines", default=MACHINES, help="Beside the nominal one.")
@click.option("--program", "wanted", multiple=True, type=click.Choice([*PROGRAMS]))
@click.option("--finer", "times", default=1, help="Times the substeps, on these machines.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the errors on all machines.")
def main(machines: int, wanted: tuple[str, ...], times: int, plot: Path | None) -> None:
    """Print the tables of the page."""
    rows, pairs, bouts = [], [], []
    for program in wanted or PROGRAMS:
        where, each = scenario(program), designs(program)
        rows += [row(program, name, figures(design, where)) for name, design in each.items()]
        if program == WHOLE:
            continue
        found = compare(each, finer(where, times), SPREAD, machines)
        pairs += paired(program, found)
        bouts += [bout._replace(name=program) for bout in found.bouts]
    if plot is not None and bouts:
        save(drawn(found._replace(bouts=bouts)), plot)
    units = (*MEASURED.values(), "overshoot [µm, mdeg]", "chatter [mV]")
    click.echo(markdown(("program", "controller", *units), rows))
    click.echo(markdown(("program", "against", *MEASURED.values(), "stable"), pairs))


if __name__ == "__main__":
    main()
