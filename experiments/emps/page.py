"""The tables of the page of EMPS; see README.md beside this file.

EMPS_DATA=FOLDER python -m experiments.emps.page
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import click

from experiments.emps import compared
from experiments.emps.inverse import inverse_dynamics
from experiments.emps.logs import Log, log
from experiments.emps.replay import PUBLISHED, by_speed, repeated, replayed, rms
from experiments.shared import markdown
from hfc_design.cli.usage import Plain
from hfc_design.files.named_scenario import load_scenario
from hfc_design.plotting.files import save
from hfc_design.report.comparison.plots import machines as drawn

#: Voltage of a pulse: as it is documented, in round numbers, and as the second log has it.
PULSE = 5.0
REPLAY = (
    "stage",
    "first log",
    "second log, pulses of 5 V",
    "of the voltage that it has",
    "first log, not in every period",
)
SPEEDS = ("stage", "speed", "forwards", "backwards")
METRICS = {"rms_error_mm": 1e3, "max_error_mm": 1e3, "rms_voltage_change_V": 1.0}
COMPARED = ("motion", "controller", "stable", "rms error [µm]", "largest [µm]", "chatter [V]")
MICRONS = 1e3
NOT_DRAWN = ("recorded-no-delay", "recorded-observer")


def stages(first: Log | None = None, identified: Path | None = None) -> dict[str, dict[str, float]]:
    """The parameters that the logs are replayed with; ``identified`` is a scenario with others."""
    found = {"published": PUBLISHED, "fitted": {k: compared.fitted()[k] for k in PUBLISHED}}
    if first is not None:
        found["inverse dynamics"] = {"viscous_asymmetry": 0.0, **inverse_dynamics(first)}
    if identified is not None:
        own = load_scenario(str(identified)).plant.parameters
        found["identified"] = {key: own.get(key, 0.0) for key in PUBLISHED}
    return found


def parameters(first: Log | None = None, identified: Path | None = None) -> list[list[str]]:
    """Of each stage."""
    each = stages(first, identified).values()
    return [[key, *(f"{own[key]:.4g}" for own in each)] for key in PUBLISHED]


def replays(
    first: Log, second: Log, identified: Path | None = None
) -> tuple[list[list[str]], list[list[str]]]:
    """How far the simulated loop is off both logs, and what brakes more than in it."""
    rows, speeds = [], []
    for name, own in stages(first, identified).items():
        off = replayed(first, own)
        others = (replayed(second, own, pulse) for pulse in (PULSE, second.pulse))
        measured = f"{MICRONS * repeated(first, off):.2f}"
        numbers = (rms(off), *map(rms, others))
        rows.append([name, *(f"{MICRONS * x:.2f}" for x in numbers), measured])
        speeds += [[name, *row] for row in by_speed(first, off)]
    return rows, speeds


def drive(one: Log) -> str:
    """What the amplifier had to do."""
    error = one.reference[one.earlier :] - one.position
    return (
        f"largest command {abs(one.command).max():.2f} V of 10, tracking error "
        f"{MICRONS * rms(error):.2f} µm rms, pulse {one.pulse:.3f} V"
    )


@click.command(cls=Plain)
@click.option("--machines", default=compared.MACHINES, help="Beside the nominal one.")
@click.option("--identified", type=click.Path(path_type=Path), help="A scenario of hfc identify.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw the errors on all machines.")
def main(machines: int, identified: Path | None, plot: Path | None) -> None:
    """Print the tables of the page."""
    first, second = log("first"), log("second")
    rows, speeds = replays(first, second, identified)
    parts = [
        markdown(("parameter", *stages(first, identified)), parameters(first, identified)),
        f"first log: {drive(first)}\nsecond log: {drive(second)}\n",
        markdown(REPLAY, rows),
        markdown(SPEEDS, speeds),
    ]
    with TemporaryDirectory() as place:
        found = compared.compared((first, second), Path(place), machines)
    parts.append(markdown(COMPARED, [*compared.rows(found, METRICS)]))
    others = [*found.designs][1:]
    parts.append(markdown(("motion", *others), [*compared.paired(found, "rms_error_mm")]))
    if plot is not None:
        bouts = [bout for bout in found.bouts if bout.name not in NOT_DRAWN]
        save(drawn(found._replace(bouts=bouts)), plot)
    click.echo("\n".join(parts), nl=False)


if __name__ == "__main__":
    main()
