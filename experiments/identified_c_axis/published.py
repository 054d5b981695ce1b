"""What a log of the loop of Lin & Lee's Table I tells of the C-axis; see README.md.

python -m experiments.identified_c_axis.published
"""

import click

from experiments.identified_c_axis.logs import log
from experiments.shared import markdown
from hfc_design.cli.usage import Plain
from hfc_design.files.named_scenario import load_scenario
from hfc_design.identify.identified import identify
from hfc_design.identify.request import Task

DESIGN, SCENARIO = "lin-lee-1999-table-1", "c-axis-ramp"
SENSORS = {"sensors.encoder_resolution": 1.7e-6, "sensors.noise": 1e-6}


@click.command(cls=Plain)
def main() -> None:
    """Print what hfc identify --plant c-axis says of it, the load known to be 0."""
    scenario = load_scenario(SCENARIO, SENSORS)
    known = frozenset({"load"})
    task = Task(scenario, axis=0, design=None, names=None, bandwidth=None, known=known)
    found = identify(task, {"log": log(DESIGN, scenario)})
    parameters, _ = found.tables()
    click.echo(markdown(parameters.head, parameters.rows))
    click.echo("\n".join((*found.notes, f"record next: {found.advice_line()}")))


if __name__ == "__main__":
    main()
