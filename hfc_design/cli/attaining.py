"""``hfc attainable``: how good any controller of a C-axis could be."""

import json
from pathlib import Path

import click

from hfc_design.cli import options as common
from hfc_design.cli.options import Texts

DESIGN_HELP = "Say how near this design comes [default: that of the run]."


@click.command(short_help="How good the best controller of a C-axis could be.")
@click.argument("name", metavar="SCENARIO", type=common.SCENARIO)
@common.named("--design", kind=common.DESIGN, help=DESIGN_HELP)
@common.setting
@common.as_json
@common.with_plugins({key: text for key, text in common.CHOICES.items() if key == "plant"})
def attainable(
    name: str, design: str | None, changes: Texts, as_json: bool, plant: str = ""
) -> None:
    """Between what and what the best sum |e| lies in SCENARIO, whatever the controller.

    SCENARIO is a built-in name, a TOML file, or the folder of a finished run, which keeps the
    answer as attainable.json and in its page. Of C-axes with a limit of the voltage, of the nominal
    machine: a certified lower bound, and what the best voltage does that was found with everything
    known beforehand.
    """
    from hfc_design.core.console import show_rows
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.report.page import write_page
    from hfc_design.runs.attained import HEADS, attained, attained_rows, keep_attained, left_out
    from hfc_design.runs.run import DESIGN, finished_run

    folder = Path(name)
    if (folder / DESIGN).is_file() and not (changes or design or plant):
        scenario, result = finished_run(folder)
        found = keep_attained(scenario, result.design, folder)
        write_page(scenario, result, folder)
    else:
        source = str(folder / "config.toml") if folder.is_dir() else name
        found = attained(load_scenario(source, [*filter(None, [plant]), *changes]), design)
    if as_json:
        click.echo(json.dumps(found))
        return
    own = any("sum_error" in one for one in found["motions"].values())
    shown = HEADS if own else HEADS[:2]
    caption = f"sum |e| over all samples [rad]{left_out(found)}"
    heads = ["motion", *(head.replace(" ", "\n") for head in shown)]
    rows = attained_rows(found)
    cells = [[cell.replace("–", "-") for cell in row[: len(heads)]] for row in rows]
    show_rows(heads, cells, caption=caption, caption_justify="left")
