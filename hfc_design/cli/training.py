"""``hfc train``: a neural network learns what a design does."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from hfc_design.cli import options as common
from hfc_design.cli.options import Texts

if TYPE_CHECKING:
    from hfc_design.files.design import Design
    from hfc_design.files.scenario import Scenario

NETWORK_HELP = (
    "A number beside the weights, as in error_unit=0.005; others are change_unit, command_unit, "
    "slope, momentum, rate (on line), xi."
)


@click.command(short_help="Teach a neural network what DESIGN does.")
@common.on_scenario
@common.output("--out", help="Design file [default: neural-NAME.json].")
@common.force
@common.named("--start", kind=common.DESIGN, help="Neural design to go on from [default: drawn].")
@click.option("--hidden", type=int, help="Units of the hidden layer [default: 25].")
@click.option("--seed", type=int, help="Seed of their weights [default: 0].")
@click.option("--training-rate", "rate", type=float, help="Rate of learning [default: 0.5].")
@click.option("--passes", type=int, help="Through all samples [default: 1].")
@click.option("--network", multiple=True, metavar="KEY=VALUE", help=NETWORK_HELP)
@common.memory
@common.with_plugins(common.CHOICES)
def train(
    found: "Design",
    where: "Scenario",
    out: Path | None,
    start: str | None,
    network: Texts,
    **lesson: Any,
) -> None:
    """Teach a neural network what DESIGN does in the motion of its scenario.

    DESIGN, of any kind, is simulated; a network of one hidden layer learns the commands of all axes
    from the errors and their changes, by back-propagation, and becomes a design of kind neural,
    which goes on learning on line.
    """
    from hfc_design.controllers.neural.record import Lesson
    from hfc_design.formats import FORMATS
    from hfc_design.simulation.teaching import taught

    given = {key: value for key, value in lesson.items() if value is not None}
    learnt = taught(found, where, network, start, Lesson()._replace(**given))
    path = out or common.free(Path(f"{learnt.design.name}.json"))
    FORMATS["json"].write(learnt.design, path)
    told, unit = learnt.training, learnt.unit
    click.echo(
        f"{learnt.samples} samples of {told.taught:.3g} {unit} rms: off by {told.before:.3g} "
        f"{unit} before, by {told.after:.3g} {unit} after"
    )
    click.echo(path)
