"""How often the intervals of ``hfc identify`` hold the true parameters; see README.md.

python -m experiments.identified_c_axis.coverage
"""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import click
import jax
import numpy as np

from experiments.identified_c_axis.logs import DESIGN, HERE, log, told
from experiments.shared import markdown
from hfc_design.cli.usage import Plain
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.fit import Fit, bandwidths, by_command
from hfc_design.identify.identifiability import BOUND, Certainty, certainty, hold_untold
from hfc_design.identify.parameters import free_parameters
from hfc_design.identify.recording import Recording
from hfc_design.simulation.machines import drawn
from plants.c_axis import C_AXIS, CAxisParameters

#: Every parameter of a machine is within this share of the nominal one's, where the fit begins.
SPREAD = 0.2
STATES = ("yes", "given", "held", "no", BOUND)
HEAD = ("parameter", " / ".join(STATES), "inside", "mean z", "sd of z", "standard error")


class Row(NamedTuple):
    """A parameter in a repeat."""

    repeat: int
    parameter: str
    state: str  # see ``Certainty``
    true: float
    value: float
    low: float
    high: float
    error: float  # standard, relative


def identified(recorded: Recording, near: bool) -> tuple[Fit, Certainty]:
    """What ``hfc identify --plant c-axis --set load.constant=0`` finds; ``near``: by one start."""
    tried = bandwidths(recorded, None)
    wanted = free_parameters(C_AXIS, {}, known=("load",))
    fit = by_command(wanted, recorded, 1, tried, 0, near=near)
    fit, known, _ = hold_untold(fit, certainty(fit))
    return fit, known


def repeat(base: Scenario, machine: CAxisParameters, k: int, near: bool) -> list[Row]:
    """A machine and noise of its own."""
    changes = {f"plant.parameters.{name}": x for name, x in machine._asdict().items()}
    fit, known = identified(log(DESIGN, load_scenario(base, changes | {"sensors.seed": k})), near)
    names = fit.free.names
    held = {
        name: getattr(C_AXIS.parameters(), name)
        for name, state in zip(names, known.state, strict=True)
        if state == "held"
    }
    expected = told(machine, held)
    columns = (known.value, known.low, known.high, known.error)
    return [
        Row(k, name, state, float(getattr(expected, name)), *map(float, numbers))
        for name, state, *numbers in zip(names, known.state, *columns, strict=True)
    ]


def rows_of(file: Path) -> list[Row]:
    """What was found before."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as lines:
        return [
            Row(int(k), name, state, *map(float, numbers))
            for k, name, state, *numbers in csv.reader(lines)
        ]


def write(file: Path, rows: list[Row]) -> None:
    """Append to what was found before."""
    with file.open("a", encoding="utf-8", newline="") as lines:
        csv.writer(lines).writerows(rows)


def table(rows: list[Row]) -> Iterator[list[str]]:
    """``HEAD`` of every parameter, by the repeats that tell it."""
    for name in dict.fromkeys(row.parameter for row in rows):
        own = [row for row in rows if row.parameter == name]
        counts = " / ".join(str(sum(row.state == state for row in own)) for state in STATES)
        sure = [row for row in own if row.state in ("yes", "given")]
        if not sure:
            yield [name, counts, *4 * ["–"]]
            continue
        inside = sum(row.low <= row.true <= row.high for row in sure)
        z = np.array([np.log(row.value / row.true) / row.error for row in sure])
        error = np.median([row.error for row in sure])
        numbers = f"{z.mean():+.2f}", f"{z.std():.2f}", f"{100 * error:.2g} %"
        yield [name, counts, f"{inside} of {len(sure)}", *numbers]


@click.command(cls=Plain)
@click.option("--repeats", default=100, help="Machines, each with noise of its own.")
@click.option("--starts", type=click.Choice(["1", "100"]), default="1", help="Of each fit.")
@click.option("--out", type=click.Path(path_type=Path), default="runs/identified_c_axis.csv")
def main(repeats: int, starts: str, out: Path) -> None:
    """Print the tables of the page; repeats that stand in --out are not done again."""
    base = load_scenario(str(HERE / "log.toml"))
    (true,) = drawn(base.plant, SPREAD, 100, seed=0)[0].actual
    rows = rows_of(out)
    out.parent.mkdir(parents=True, exist_ok=True)
    for k in sorted({*range(1, repeats + 1)} - {row.repeat for row in rows}):
        machine = jax.tree.map(lambda leaf, k=k: float(leaf[k]), true)
        more = repeat(base, machine, k, starts == "1")
        write(out, more)
        rows += more
    click.echo(markdown(HEAD, [*table(rows)]), nl=False)


if __name__ == "__main__":
    main()
