"""``hfc identify``: a machine's parameters from its log."""

from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING

import click

from hfc_design.cli.named import DESIGN, PLANT, SCENARIO, named
from hfc_design.cli.options import PATH, Texts, as_json, force, free, setting, with_plugins

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario

COLUMN_HELP = "Which column a signal is, and its unit, as in 'position=qm [m]'; several times."
CHECK_COLUMN_HELP = "The same where --check-log differs."
LOOP_HELP = "The controller in the loop that recorded LOG: its loop is replayed too."
SCENARIO_HELP = "Plant, values to start from, sensors, limits [default: of --controller]."


@click.command(short_help="Find the parameters of a machine from what LOG has recorded.")
@click.argument("log", type=PATH)
@named("--plant", kind=PLANT, help="NAMES, or an own one as module:OBJECT.")
@named("--scenario", kind=SCENARIO, help=SCENARIO_HELP)
@setting
@click.option("--axis", help="Which one, of a machine of several.")
@click.option("--free", "names", help="Parameters to look for [default: all but exact ones and 0].")
@named("--controller", kind=DESIGN, help=LOOP_HELP)
@click.option("--open-loop", is_flag=True, help="Replay the plant without an observer.")
@click.option("--bandwidth", type=click.FloatRange(0.0), help="Of the observer [Hz].")
@click.option("--column", "columns", multiple=True, metavar="NAME=COLUMN", help=COLUMN_HELP)
@click.option(
    "--sample-time",
    type=click.FloatRange(0.0, min_open=True),
    help="[s], where LOG does not say it.",
)
@click.option("--check-log", type=PATH, help="Another log, which the result is checked on.")
@click.option(
    "--check-column", "others", multiple=True, metavar="NAME=COLUMN", help=CHECK_COLUMN_HELP
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Of the starts [default: 0].")
@click.option("--out", type=PATH, help="Folder [default: LOG-identified].")
@force
@as_json
@with_plugins({})
def identify(
    log: Path,
    names: str | None,
    open_loop: bool,
    bandwidth: float | None,
    columns: Texts,
    others: Texts,
    check_log: Path | None,
    sample_time: float | None,
    seed: int,
    out: Path | None,
    as_json: bool,
    **given: object,
) -> None:
    """Find the parameters of a machine that make it do what LOG has recorded.

    LOG is a CSV file with a header, what LinuxCNC's halscope or halsampler write, a .mat of MATLAB
    up to version 7, .npy or .npz. It needs the position and the command, or, with --controller, the
    position and the reference. The plant is simulated under the recorded command from a hundred
    starts; the folder gets report.html, identified.json, and scenario.toml, which hfc design takes.
    """
    from hfc_design.cli import identified_logs, identified_tables
    from hfc_design.core.records import UserError
    from hfc_design.identify import aim, identified

    if open_loop and bandwidth is not None:
        raise UserError("--open-loop: has no observer; leave out --bandwidth")
    scenario, design, made = _machine(**given)  # type: ignore[arg-type]
    axes = scenario.plant.machine.axes
    axis = axes.index(str(given["axis"])) if given["axis"] else 0
    drive = scenario.machine.drives[axis]
    # What is mistyped is told first, then what is in the way; only then anything is read.
    wanted = [name.strip() for name in names.split(",")] if names else None
    hz = 0.0 if open_loop else bandwidth
    task = identified.Task(scenario, axis, design, wanted, hz, seed)
    identified.looked_for(task)
    sources = identified_logs.sources(log, drive, columns, others, check_log)
    name = identified_logs.called(log)
    path = free(out or Path(aim.called(name)), folder=True)
    if isfile(path):
        raise UserError(f"--out {path}: is a file, and what is written is a folder")
    logs, scenario = identified_logs.recordings(sources, scenario, drive, sample_time)
    task = task._replace(scenario=scenario)
    found = identified.identify(task, logs, lambda line: click.echo(line, err=True))
    identified_tables.write(found, name, path, not made)
    identified_tables.tell(found, name, path, as_json)


def _machine(
    plant: str | None,
    scenario: str | None,
    changes: Texts,
    axis: str | None,
    controller: str | None,
) -> "tuple[Scenario, Design | None, bool]":
    """The scenario of the one axis, the controller, and whether the scenario is made up here."""
    from hfc_design.core.records import UserError
    from hfc_design.files.machine import ALL_PLANTS
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.files.pairing import load_design, own_scenario

    design = load_design(controller) if controller else None
    name = ALL_PLANTS.resolve(plant).name if plant else None
    made = scenario is None and design is None
    if scenario is not None:
        found = load_scenario(scenario, changes)
    elif design is not None:
        found = own_scenario(design, str(controller), changes)
    elif name is not None:
        # Of these only the plant counts.
        still = {"reference": {"kind": "step", "height": 0.0}, "controller": {"kind": "pid"}}
        found = load_scenario({"name": "log", "plant": {"name": name}, **still}, changes)
    else:
        raise UserError(
            "hfc identify: which machine is it? say --plant, --scenario or --controller"
        )
    if name is not None and found.plant.name != name:
        raise UserError(f"--plant {plant}: the scenario is for the plant {found.plant.name}")
    axes = found.plant.machine.axes
    if len(axes) > 1 and (axis not in axes or made):
        told = f"{found.plant.name} has the axes {', '.join(axes)}"
        why = "; say --scenario too" if axis in axes else ""
        raise UserError(f"--axis {axis}: {told}{why}" if axis else f"--axis: which one? {told}")
    if len(axes) == 1 and axis is not None:
        raise UserError(f"--axis {axis}: {found.plant.name} has only one")
    return found, design, made
