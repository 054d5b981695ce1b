"""Commands that simulate: score, simulate and train with one design, batch with many runs."""

from pathlib import Path
from textwrap import fill
from typing import Any

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import AS_JSON, PATH, Texts, argument, command, option
from hfc_design.cli.names import DESIGN
from hfc_design.cli.options import Loops
from hfc_design.cli.usage import refusal

SAMPLES_HELP = "Number of random machines [default: 1000, or robust.unseen of the scenario]."


@command("Fitness, merit, metrics and robustness of DESIGN.", last=common.CHOOSING)
def score(
    loops: Loops = common.ON_SCENARIOS,
    spread: float | None = option("Vary the machine's parameters by up to this share."),
    samples: int | None = option(SAMPLES_HELP),
    seed: int | None = option("Random seed [default: 0]."),
    motion: str | None = option("Only this motion of a scenario with several, on all machines."),
    plot: Path | None = common.output("Draw the distributions of the metrics."),
    as_json: bool = AS_JSON,
) -> None:
    """Fitness, merit and metrics of DESIGN (a built-in name, a design file or a run folder).

    With --plant: on another plant, with parameters from --set plant.parameters.NAME=..., as a test
    of the model. That plant needs the signals that DESIGN reads, in the same units.

    With --spread 0.2: on many machines, each physical parameter within 20 % of its value; prints
    the share that is stable, and quantiles of every metric. A machine is stable if the motion
    settles: a copy with slightly different initial state ends on the same motion, no drive stays at
    a limit of its command, and the error of the last quarter stays near that of the nominal machine
    or within 5 % of the reference.
    """
    from hfc_design.cli.scoring import score_one
    from hfc_design.files.loop_setup import machine

    options = {"samples": samples, "seed": seed, "plot": plot}
    given: dict[str, Any] = {name: x for name, x in options.items() if x is not None}
    if spread is None and given:
        raise refusal(f"--{next(iter(given))} needs --spread, as in --spread 0.2")
    if plot is not None and len(loops.scenarios) > 1:
        raise refusal("--plot draws one scenario; name only one")
    if motion is not None:
        loops = loops._replace(scenarios=[where.motion(motion) for where in loops.scenarios])
    for where in loops.scenarios:  # checks all before the first simulation
        machine(loops.design, where)
    for k, where in enumerate(loops.scenarios):
        if k and not as_json:
            click.echo()
        score_one(loops.design, where, spread, as_json, **given)
        if not as_json:
            _show_kept(loops, k)


def _show_kept(loops: Loops, k: int = 0, err: bool = False) -> None:
    """Print which of its own settings a design keeps on a scenario other than its own."""
    from hfc_design.files.transfer import transfer_report

    where = loops.scenarios[k]
    if loops.elsewhere or where.plant.name != loops.design.plant.name:
        for note in transfer_report(loops.design, where):
            click.echo(note, err=err)


@command("Simulate DESIGN and write its trajectory, or draw it.", last=common.CHOOSING)
def simulate(
    loops: Loops = common.ON_SCENARIO,
    csv: Path | None = common.output("Write the trajectory."),
    plot: Path | None = common.output("Draw it (png, svg or pdf)."),
    learned: Path | None = common.output("Write the design with its learned state."),
    motion: str | None = option("Motion, of a scenario with several [default: the first]."),
) -> None:
    """Simulate DESIGN and write its trajectory; without --csv, --plot or --learned to stdout.

    --learned writes an adaptive design in its state after the motion, to start the next one.
    """
    from hfc_design.core.checkpoint import write_whole
    from hfc_design.core.console import room
    from hfc_design.formats import FORMATS
    from hfc_design.runtime import Machine
    from hfc_design.simulation.evaluating import evaluate, learned_in, notes, trajectory_csv

    design, where = loops.design, loops.only
    if motion is not None or where.motions:
        names = [one.name for one in where.motions]
        where = where.motion(motion)
        if motion is None and names[1:]:
            click.echo(f"motion {names[0]} of {', '.join(names)}: --motion names another", err=True)
    if learned is not None:  # refuses a design that does not adapt, before the simulation
        Machine(design, where.plant.machine.axes).learned()
    evaluation = evaluate(design, where)
    for note in notes(where, {design.name: evaluation}):
        click.echo(fill(note, room()), err=True)
    _show_kept(loops, err=True)
    if plot is not None:
        from hfc_design.plotting.files import save
        from hfc_design.report import plots

        save(plots.motion(evaluation, f"{design.name} on {where.name}"), plot)
    if csv is not None:
        write_whole(csv, trajectory_csv(evaluation).encode())
    if learned is not None:
        FORMATS["json"].write(learned_in(design, where, evaluation), learned)
    written = [*filter(None, (csv, plot, learned))]
    for path in written:
        click.echo(path)
    if not written:
        click.echo(trajectory_csv(evaluation), nl=False)


NETWORK_HELP = (
    "A number besides the weights, as in error_unit=0.005; others are change_unit, "
    "command_unit, slope, momentum, rate (on line), xi."
)


@command("Train a neural network to imitate DESIGN.", last=common.CHOOSING)
def train(
    loops: Loops = common.ON_SCENARIO,
    out: Path | None = common.output("Design file [default: neural-NAME.json]."),
    start: str | None = option(
        "Neural design to start from [default: random weights].", kind=DESIGN
    ),
    hidden: int | None = option("Units of the hidden layer [default: 25]."),
    seed: int | None = option("Random seed of the weights [default: 0]."),
    training_rate: float | None = option("Learning rate [default: 0.5]."),
    passes: int | None = option("Passes through all samples [default: 1]."),
    network: Texts = option(NETWORK_HELP, metavar="KEY=VALUE"),
) -> None:
    """Train a neural network to imitate DESIGN in the motion of its scenario.

    DESIGN, of any kind, is simulated; a network of one hidden layer learns the commands of all axes
    from the errors and their changes, by back-propagation, and becomes a design of kind neural,
    which continues to learn on line.
    """
    from hfc_design.controllers.neural.record import Lesson
    from hfc_design.formats import FORMATS
    from hfc_design.simulation.imitation import taught

    lesson = {"hidden": hidden, "seed": seed, "rate": training_rate, "passes": passes}
    given: dict[str, Any] = {key: value for key, value in lesson.items() if value is not None}
    result = taught(loops.design, loops.only, network, start, Lesson()._replace(**given))
    path = out or common.free(Path(f"{result.design.name}.json"))
    FORMATS["json"].write(result.design, path)
    training, unit = result.training, result.unit
    click.echo(
        f"{result.samples} samples of {training.taught:.3g} {unit} rms: off by "
        f"{training.before:.3g} {unit} before, by {training.after:.3g} {unit} after"
    )
    click.echo(path)


FILE = click.Path(path_type=Path, exists=True, dir_okay=False)
BATCH_SET_HELP = "Change a value in every cell by its dotted key, as in search.generations=20."


@command("Run every cell of a batch FILE: scenarios x seeds x settings.", last=common.KNOWING)
def batch(
    file: Path | None = argument(PATH, required=False),
    out: Path | None = option("Folder [default: runs/NAME]."),
    changes: Texts = option(BATCH_SET_HELP, "--set", metavar="KEY=VALUE"),
    dry_run: bool = option("Show the plan and the expected time."),
    status: Path | None = option("Show the state of a batch's cells."),
    workers: int | None = option("Number of cells that run here at once.", kind=click.IntRange(1)),
    scheduler: str | None = option(
        "Run them on the workers of a Dask scheduler.", metavar="ADDRESS"
    ),
    shared: bool = option("The workers see the folder and write into it."),
    tls_ca: Path | None = option(
        "Certificate authority of the scheduler and the client.", kind=FILE
    ),
    tls_cert: Path | None = option("Certificate of the client.", kind=FILE),
    tls_key: Path | None = option("Private key of the client.", kind=FILE),
    anyway: bool = option(common.ANYWAY_HELP),
    _memory: str | None = common.MEMORY,
) -> None:
    """Run every cell of a batch FILE (TOML): scenarios x seeds x any setting.

    Finished cells are skipped, interrupted ones continue, and a failure does not stop the others.
    Without --workers or --scheduler cells run one after the other, each on all cores.
    """
    from hfc_design.batch import session
    from hfc_design.batch.plan import read_batch
    from hfc_design.batch.runner import WorkerOptions

    if (file is None) == (status is None):
        raise refusal("give either a batch file or --status DIR")
    if workers is not None and scheduler is not None:
        raise refusal("give either --workers N or --scheduler ADDRESS")
    if shared and scheduler is None:
        raise refusal("--shared needs --scheduler ADDRESS")
    tls = (tls_ca, tls_cert, tls_key)
    if any(tls) and not (all(tls) and scheduler):
        raise refusal("--tls-ca, --tls-cert and --tls-key must be given together, with --scheduler")
    if status is not None:
        session.show_status(status)
    elif file is not None:
        plan, options = read_batch(file, changes), None
        if workers is not None or scheduler is not None:
            options = WorkerOptions(workers, scheduler, shared, tls)
        if dry_run:
            session.show_plan(plan.cells, plan.folder(out))
        else:
            session.run(plan, plan.folder(out), options, anyway)
