"""The controller that hfc design five-axis-robust ends with, on programs that it was not made on.

python -m experiments.designed_contours.five_axes             # the tables of the page, some minutes
"""

from collections.abc import Iterator
from pathlib import Path

import click

from experiments.shared import markdown
from hfc_design.files.design import Design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.files.scenario import Scenario
from hfc_design.simulation.comparing import compare
from hfc_design.simulation.comparison import Comparison

HERE = Path(__file__).parent
DESIGNED = "designed"
#: What each controller is called -> its design.
CONTROLLERS = {
    DESIGNED: HERE / "five_axes.json",
    "PID with feed-forward": HERE / "five_axes_pid_ff.json",
    "PID of 2009": "lin-gai-2009-pid",
    "fuzzy sliding of 2009": "lin-gai-2009-fuzzy-sliding",
    "compensated of 2009": "lin-gai-2009-fuzzy-sliding-compensated",
}
SLOW = f"reference.file={HERE / 'five_axes_slow.ngc'}"
COUPLED = "plant.name=five-axis-coupled"
#: What the tables call it -> scenario, what is changed of it, and of every design.
PROGRAMS: dict[str, tuple[str, tuple[str, ...], dict[str, str]]] = {
    "program of 2009": ("five-axis-program", (), {}),
    "as printed": ("five-axis-program-printed", (), {}),
    "blade": ("five-axis-blade", (), {}),
    "blade at F900": ("five-axis-blade", (SLOW,), {}),
    "program, coupled axes": ("five-axis-program", (COUPLED,), {"plant.name": COUPLED[11:]}),
    "blade, coupled axes": ("five-axis-blade", (COUPLED,), {"plant.name": COUPLED[11:]}),
}
#: Metric -> what a table calls it.
MEASURED = {
    "rms_contour_error_mm": "contour, rms [µm]",
    "max_contour_error_mm": "largest [µm]",
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


def nominal(program: str, found: Comparison) -> Iterator[list[str]]:
    """A row of each controller on the nominal machine."""
    for name, side in found.bouts[0].sides.items():
        own = [f"{1e3 * side.nominal[key]:.3g}" for key in MEASURED]
        beyond = max(x for key, x in side.nominal.items() if OVERSHOOT in key)
        chatter = f"{1e3 * side.nominal[CHATTER]:.3g}"
        yield [program, name, *own, f"{1e3 * beyond:.2g}", chatter]


def paired(program: str, found: Comparison) -> Iterator[list[str]]:
    """A row of each other controller: how the designed one differs, machine by machine."""
    sides = found.bouts[0].sides
    for other in list(CONTROLLERS)[1:]:
        cells = []
        for key in MEASURED:
            one = next(x for x in found.differences if (x.metric, x.second) == (key, other))
            cells.append(f"{one.ratio:.3f} ({one.better})")
        stable = (f"{int(sides[name].stable.sum())}" for name in (DESIGNED, other))
        yield [program, other, *cells, " / ".join(stable)]


@click.command()
@click.option("--machines", default=MACHINES, help="Beside the nominal one.")
@click.option("--program", "wanted", multiple=True, type=click.Choice([*PROGRAMS]))
def main(machines: int, wanted: tuple[str, ...]) -> None:
    """Print the tables of the page."""
    rows, pairs = [], []
    for program in wanted or PROGRAMS:
        found = compare(designs(program), scenario(program), SPREAD, machines)
        rows += nominal(program, found)
        pairs += paired(program, found)
    units = (*MEASURED.values(), "overshoot [µm, mdeg]", "chatter [mV]")
    click.echo(markdown(("program", "controller", *units), rows))
    click.echo(markdown(("program", "against", *MEASURED.values(), "stable"), pairs))


if __name__ == "__main__":
    main()
