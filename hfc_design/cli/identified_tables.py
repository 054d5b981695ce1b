"""What ``hfc identify`` reads, writes and shows."""

import shlex
import sys
from pathlib import Path

import click

from hfc_design.cli.options import Texts
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.console import plain_table, terminal
from hfc_design.core.records import UserError, writing
from hfc_design.core.texts import about
from hfc_design.files.scenario import Scenario
from hfc_design.identify import aim, page
from hfc_design.identify.identified import Identified
from hfc_design.identify.recording import Recording, recording
from hfc_design.logs.columns import mapped
from hfc_design.logs.reading import read_log
from hfc_design.logs.signals import signals
from hfc_design.report import REPORT
from plants import Drive


def recordings(
    log: Path,
    base: Scenario,
    axis: str | None,
    columns: Texts,
    others: Texts,
    check_log: Path | None,
    sample_time: float | None,
    **_: object,
) -> tuple[dict[str, Recording], Scenario]:
    """The logs by their names, and the scenario in the cycle and the substeps that they need.

    Raises:
        UserError: one cannot be read or has not what is needed; the line says which and why.
    """
    if others and check_log is None:
        raise UserError("--check-column: needs --check-log")
    names = base.plant.machine.axes
    drive = base.machine.drives[names.index(axis) if axis else 0]
    found = {log.name: _recording(log, drive, columns, sample_time)}
    if check_log is not None:
        name = check_log.name if check_log.name not in found else f"{check_log.name} (check)"
        found[name] = _recording(check_log, drive, (*columns, *others), sample_time)
    told = found[log.name]
    return found, _in_cycle(base, drive, told, found)


def _recording(path: Path, drive: Drive, columns: Texts, sample_time: float | None) -> Recording:
    read = read_log(path)
    with about(path):
        asked = {one.name: one for one in map(mapped, columns)}  # the last of a name counts
        return recording(signals(read, drive, [*asked.values()], sample_time), drive)


def _in_cycle(
    scenario: Scenario, drive: Drive, told: Recording, logs: dict[str, Recording]
) -> Scenario:
    """The scenario with the logs' sample time, and substeps that their speeds need."""
    every = told.sample_time
    for name, other in logs.items():
        if abs(other.sample_time / every - 1.0) > 1e-3:
            raise UserError(f"{name}: is sampled every {other.sample_time:g} s, not {every:g} s")
    speed = max(_speed(one) for one in logs.values())
    axis = scenario.plant.each()[scenario.machine.drives.index(drive)]
    substeps = scenario.simulation.substeps
    while drive.fastest(axis.parameters, every / substeps) < speed and substeps < 1000:
        substeps *= 2
    changes = {"sample_time_s": every, "substeps": substeps}
    simulation = scenario.simulation.model_copy(update=changes)
    return scenario.model_copy(update={"simulation": simulation})


def _speed(told: Recording) -> float:
    """Largest speed over ten samples: noise is none."""
    place = told.place
    return float(abs(place[10:] - place[:-10]).max() / (10 * told.sample_time))


def write(found: Identified, log: str, path: Path, from_file: bool) -> None:
    """Write the folder.

    Raises:
        UserError, RunError: it cannot be written, or is not what a scenario can hold.
    """
    command = shlex.join(["hfc", *sys.argv[1:]])
    texts = {
        "scenario.toml": aim.scenario_text(found, log, from_file).encode(),
        "identified.json": page.record(found, log).encode(),
        REPORT: page.page(found, log, command),
    }
    with writing(path):
        path.mkdir(parents=True, exist_ok=True)
    for name, content in texts.items():
        write_whole(path / name, content)


def tell(found: Identified, log: str, path: Path, as_json: bool) -> None:
    """Show what was found."""
    if as_json:
        click.echo(page.record(found, log), nl=False)
        return
    table = plain_table()
    for k, head in enumerate(page.HEADS):
        table.add_column(head, justify="left" if k < 2 else "right", no_wrap=k == 0)
    for row in page.parameter_rows(found):
        table.add_row(*(cell.replace("–", "-") for cell in row))
    terminal().print(table)
    click.echo(page.interval_line(found))
    click.echo()
    checks = plain_table()
    for head in ("log", "replayed in", "rms before", "rms after"):
        checks.add_column(head, justify="right" if head.startswith("rms") else "left")
    for row in page.check_rows(found):
        checks.add_row(*(cell.replace("µ", "u") for cell in row))
    terminal().print(checks)
    click.echo()
    click.echo(page.agreeing_line(found))
    for line in (*page.untold_lines(found), *found.notes):
        click.echo(line)
    if line := page.advice_line(found):
        click.echo(f"record next: {line.replace('µ', 'u').replace('±', '+-')}")
    click.echo(path)
