"""Commands that exchange designs with other programs: export, import."""

import re
from pathlib import Path

import click

from hfc_design.cli import options as common
from hfc_design.cli.binding import PATH, Texts, argument, command, option
from hfc_design.cli.names import DESIGN, FORMAT, PLANT, SCENARIO
from hfc_design.cli.usage import refusal

#: Warning about tabulated terms with large errors.
COARSE = (
    "hfc: warning: --lookup {lookup} is coarse, with errors of 1 % or more: the loop "
    "will differ from the one scored; use more points"
)


MOTOR_HELP = "Of parameters: lead=5 [mm/turn],torque=0.14 [N m/command],torque_constant [N m/A]."
ON_HELP = "Scenario that gives sensors and drives [default: the one it was made for]."


@command(last=common.KNOWING)
def export(
    design: str = argument(DESIGN),
    others: Texts = common.CHANGING,
    target: str = option("Format: NAMES.", "--to", kind=FORMAT, required=True),
    scenario: str | None = option(ON_HELP, kind=SCENARIO),
    changes: Texts = common.SETTING,
    out: Path | None = common.output("File or folder to write.", folder=True),
    lookup: int | None = option(
        "Only c: table of N points instead of exp.", kind=click.IntRange(2, 32767)
    ),
    anyway: bool = option("Also export a design that diverged when it was scored."),
    motor: str | None = option(MOTOR_HELP, metavar="NAME=NUMBER,..."),
    old: Path | None = option("File of the parameters that are in the control now."),
    bare: bool = option(
        "Code of the control law only: its inputs are errors, not sensor readings."
    ),
) -> None:
    """Write DESIGN for another program."""
    from hfc_design.controllers.rules import identifier
    from hfc_design.core.overrides import set_keys
    from hfc_design.core.wording import one_of
    from hfc_design.files.loop_setup import load_design, made_for
    from hfc_design.formats import FORMATS, c_folder, check_score, connecting, with_data
    from hfc_design.formats.deployment.readme import origin

    if target not in FORMATS:
        raise refusal(f"--to {target}: unknown format; {one_of(target, FORMATS)}")
    if lookup is not None and target != "c":
        raise refusal(f"--lookup {lookup}: needs --to c (got --to {target})")
    loaded = load_design(design, others)
    if scenario or changes:
        chosen = (scenario,) if scenario else ()
        loaded = made_for(loaded, *common.scenarios_of(loaded, design, chosen, changes))
    check_score(loaded, anyway)
    if (verdict := origin(loaded).usable) and not verdict.startswith("usable"):
        click.echo(f"hfc: warning: design {loaded.name}: {verdict.replace('**', '')}", err=True)
    data = set_keys(motor.split(","), "motor") if motor else None
    form = with_data(FORMATS[target], motor=data, old=old)
    name = identifier(loaded.name) if form.called else loaded.name
    path = out or common.free(Path(name + (form.ending or form.suffix or f".{target}")))
    connect = connecting(form, bare)
    if lookup is None:
        form.write(loaded, path, connect)
        if note := form.note():
            click.echo(note)
    else:
        for axis, off in c_folder.write_lookup(loaded, path, lookup, connect).items():
            for line in off.lines:
                click.echo(f"{axis}: {line}" if axis else line)
            if off.coarse:
                click.echo(COARSE.format(lookup=lookup), err=True)
    click.echo(path)


def term_counts(text: str | None) -> tuple[int, int] | None:
    """Return the numbers of terms of both inputs from "7" or "9x5"; None for None."""
    if text is None:
        return None
    match = re.fullmatch(r"([0-9]{1,2})(?:x([0-9]{1,2}))?", text)
    counts = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
    if not all(2 <= count <= 11 for count in counts):
        raise refusal(
            f"--terms {text[:40]}: must be N or NxM with 2 to 11 terms each, as in 7 or 9x5"
        )
    return counts


KINDS = click.Choice(["flc", "aflc", "pd+hierarchical-fuzzy"])
SIGNAL_HELP = "Signal of an input of FILE, as in input1=error, if its name does not tell."


@command("Read another program's controller FILE.", name="import")
def import_(
    file: Path = argument(PATH),
    out: Path | None = common.output("Design file [default: NAME.json]."),
    terms: str | None = option(
        "Sample FILE with this number of terms per input, 2 to 11.", metavar="N|NxM"
    ),
    axis: str | None = option("Axis whose learned state FILE is, if there are several."),
    output: str | None = option("Output of FILE to import, if there are several.", metavar="NAME"),
    kind: str | None = option("Kind of the design [default: by the terms of FILE].", kind=KINDS),
    name: str | None = option("Name of the design [default: the file's]."),
    plant: str | None = option("Plant of the design: feed-drive, c-axis or your own.", kind=PLANT),
    sample_time: float | None = option("Sample time T [s] [default: 0.01, of a C-axis 0.001]."),
    like: str | None = option("Take from DESIGN what FILE does not contain.", kind=DESIGN),
    signals: Texts = option(SIGNAL_HELP, "--signal", metavar="INPUT=SIGNAL"),
) -> None:
    """Read another program's controller FILE: FLL, .fis, the tables of hfc export --to csv.

    It also reads what a controller has learned, see below.

    FILE has two inputs of 2 to 11 terms and a singleton for each rule, with product and weighted
    average. Triangles become an flc, or with seven terms a side and --kind aflc an adaptive one;
    seven Gaussians with flat tops become a hierarchy of one unit. What a design cannot represent is
    refused; within the ranges of its inputs the design computes the same as FILE. Names are kept. A
    scenario takes an flc or aflc as the start of a search with [controller] start = "NAME.json".

    An output of terms with a shape (Mamdani) is sampled: FILE is evaluated at the centres of as
    many triangles as it has terms, or of --terms, with straight lines between them. The largest
    deviation is printed, and stored in the design.

    A .txt contains the numbers written by NAME_save of exported C code, a .hal the output of halcmd
    save param: the learned state becomes a design again, with all else from --like.
    """
    from hfc_design.files.machine import ALL_PLANTS
    from hfc_design.formats import FORMATS, reading

    pairs = {}
    for item in (one for text in signals for one in text.split(",")):  # several in one, as for --at
        key, equals, signal = item.partition("=")
        if not equals:
            raise refusal(f"--signal {item}: must be INPUT=SIGNAL, as in input1=error")
        pairs[key] = signal
    plant_name = plant and ALL_PLANTS.resolve(plant).name
    counts = term_counts(terms)
    wish = reading.Wish(kind, name, plant_name, sample_time, like, pairs, counts, axis, output)
    design = reading.imported(file, wish)
    path = out or common.free(Path(f"{design.name}.json"))
    FORMATS["json"].write(design, path)
    if isinstance(sample := design.provenance.get("sampled"), dict):
        click.echo(reading.deviation_told(sample, chosen=terms is not None))
        if holes := reading.left_out_told(sample):
            click.echo(f"hfc: warning: {holes}", err=True)
    note = reading.assumed(wish, design)
    for line in (*reading.assumptions_text(design.provenance), *filter(None, [note]), path):
        click.echo(line)
