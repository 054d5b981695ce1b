"""What a hierarchy is worth over the two linear laws that it goes between: its root held at 0 or 1.

Of every design of a kind with ``schedules`` in a folder of runs, also one of a batch:

    python -m experiments.search_power.held runs/structures
"""

from pathlib import Path

import click

from hfc_design import api
from hfc_design.files.design import read_design


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, exists=True))
def main(folder: Path) -> None:
    """Print answer, share and merit of each design, and those of the better one of its laws."""
    for path in sorted(folder.glob("**/design.json")):
        design = read_design(path)
        if getattr(design.controller, "scheduled", None) is None:
            continue
        scenario, own = api.load_scenario(str(path.with_name("config.toml"))), design.controller
        found = [api.usable(design, scenario)]
        for root in (0.0, 1.0):
            held = [[root] * 7] * 7
            units = [
                one.model_copy(update={"consequents": held}) for one in design.controller.units
            ]
            law = own.model_copy(update={"units": tuple(units)})
            found.append(api.usable(design.model_copy(update={"controller": law}), scenario))
        best = max(found[1:], key=lambda use: (float(use.good.mean()), use.numbers()["merit"]))
        told = [
            f"{use.verdict}, {use.good.mean():.1%}, merit {use.numbers()['merit']:.3g}"
            for use in (found[0], best)
        ]
        click.echo(f"{path.parent}: {told[0]}; one law: {told[1]}")


if __name__ == "__main__":
    main()
