"""Tables of ``hfc list plants``: the signals and the parameters of every drive, with units."""

from textwrap import fill

from hfc_design.core.console import room, show
from hfc_design.core.tables import Table
from hfc_design.files.machine import ALL_PLANTS
from plants import Drive, machine_of


def show_plants() -> None:
    """Print every plant, with signals and nominal machine of each of its drives once."""
    shown: set[Drive] = set()
    for k, name in enumerate(ALL_PLANTS.names()):
        if k:
            print()
        machine = machine_of(ALL_PLANTS.get(name))
        print(name)
        several = len(machine.axes) > 1
        for drive in dict.fromkeys(machine.drives):
            added = [
                a for a, other in zip(machine.axes, machine.drives, strict=True) if other is drive
            ]
            if several:
                again = ", as above" if drive in shown else ""
                axes = f"{'axis' if len(added) == 1 else 'axes'} {', '.join(added)}"
                print(f"{axes}: {drive.name}{again}")
            if drive not in shown:
                _show(drive)
            shown.add(drive)


def _show(drive: Drive) -> None:
    signals = ", ".join(f"{name} [{unit}]" for name, unit in drive.units.items())
    print(fill(f"signals: {signals}", room(), subsequent_indent="  ", break_on_hyphens=False))
    defaults, units = drive.parameters()._asdict(), drive.parameter_units
    rows = [[name, f"{value:g}", units.get(name, "")] for name, value in defaults.items()]
    show(Table("", ("parameter", "default", "unit"), rows))
