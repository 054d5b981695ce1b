"""The page of an identification, and the folder that it lies in."""

import json
from pathlib import Path

from hfc_design.core.checkpoint import write_whole
from hfc_design.core.plugins import given, options
from hfc_design.core.records import writing
from hfc_design.identify import plots, words
from hfc_design.identify.aim import scenario_text
from hfc_design.identify.certainty import CONFIDENCE
from hfc_design.identify.kept import GIVEN
from hfc_design.identify.profile import LIMIT
from hfc_design.identify.result import Identified
from hfc_design.pictures.files import small_address
from hfc_design.report import REPORT, Page, rendered


def write(found: Identified, path: Path, command: str) -> None:
    """Write the folder: page, numbers, and the scenario for a search.

    ``command`` is how the page says that it was made.

    Raises:
        UserError, RunError: it cannot be written, or is not what a scenario can hold.
    """
    texts = {
        "scenario.toml": scenario_text(found).encode(),
        "identified.json": (json.dumps(found.numbers(), indent=1) + "\n").encode(),
        REPORT: page(found, command).html,
    }
    with writing(path):
        path.mkdir(parents=True, exist_ok=True)
    for name, content in texts.items():
        write_whole(path / name, content)


def _is_doubt(note: str) -> bool:
    return note.startswith(("DOUBTFUL", "NOT USABLE"))


def page(found: Identified, command: str) -> Page:
    """One file that needs nothing else."""
    return rendered(
        "identified.html.j2",
        f"{found.free.drive.name} from {found.log}",
        small_address,
        log=found.log,
        plant=found.free.drive.name,
        heads=words.HEADS,
        rows=words.parameter_rows(found),
        confidence=100 * CONFIDENCE,
        intervals=words.interval_line(found),
        agreeing=words.agreeing_line(found),
        how=found.how,
        doubts=[note for note in found.notes if _is_doubt(note)],
        notes=[note for note in found.notes if not _is_doubt(note)],
        untold=words.untold_lines(found),
        given=GIVEN in found.states,
        advice=words.advice_line(found),
        checks=words.check_rows(found),
        verdict=words.verdict(found),
        replayed=plots.replayed(found),
        closely=plots.closely(found),
        checked=plots.checked(found),
        spectrum=plots.spectrum(found),
        response=plots.response(found),
        mode=found.response and found.response.mode,
        profiles={x.name: plots.profiled(x, found.free.unit(x.name)) for x in found.profiles},
        limit=LIMIT,
        command=command,
        use=options(text for _, text in given()),
    )
