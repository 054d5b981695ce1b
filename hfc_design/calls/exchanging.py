"""Export of designs to other programs, and import from them."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hfc_design.controllers.flc.rules import FEWEST, MOST
from hfc_design.core.arguments import check_positive, check_type, check_whole, path_of
from hfc_design.core.records import UserError, option
from hfc_design.core.wording import one_of
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.loop_setup import load_design, made_for
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.formats import FORMATS, check_score, connecting, with_data
from hfc_design.formats.reading import Wish, imported


def export(
    source_design: AnyDesign,
    to: str,
    path: str | Path,
    anyway: bool = False,
    bare: bool = False,
    scenario: AnyScenario | None = None,
    motor: Mapping[str, float] | None = None,
    old: str | Path = "",
) -> Path:
    """Write a design to a file in an export format and return the path.

    The format "json" is the design file itself; ``hfc list formats`` lists all formats. Exported
    code reads the signals of the machine's sensors, or with ``bare`` the inputs of the control law
    itself. ``scenario`` sets the sensors and the drives; default: the scenario that the design was
    made for. Parameters of a control may need ``motor`` {lead, torque, torque_constant: number};
    ``old`` is a file with the parameters that are in the control now.

    Raises:
        UserError: the format does not exist or does not support this kind of controller; or the
            score of the design says that it diverged, and ``anyway`` is false.
        RunError: ``path`` cannot be written.
    """
    if to not in [*FORMATS]:  # a list, because ``to`` may be of any type
        raise UserError(f"{to!r}: unknown format; {one_of(to, FORMATS)}")
    place, design = path_of(path), load_design(source_design)
    if scenario is not None:
        design = made_for(design, load_scenario(scenario))
    check_score(design, anyway)
    form = with_data(FORMATS[to], motor=motor, old=old)
    form.write(design, place, connecting(form, bare))
    return place


def import_(path: str | Path, **wish: Any) -> Design:
    """Import a controller file of another program as a design, as ``hfc import`` does.

    ``wish`` takes the fields of ``formats.reading.Wish`` as keywords, such as the names ``plant``
    and ``like``, ``signals`` {input of the file: signal}, ``sample_time`` [s], ``terms`` (numbers
    of terms of the two inputs) and ``output`` (name of the output, if the file has several).

    Raises:
        UserError: the file cannot be read, or contains something that a design cannot represent.
    """
    if unknown := sorted(wish.keys() - {*Wish._fields}):
        raise UserError(
            f"import_: unknown option {unknown[0]!r}; available: {', '.join(Wish._fields)}"
        )
    _check_numbers(Wish(**wish))
    return imported(path_of(path), Wish(**wish))


def _check_numbers(wish: Wish) -> None:
    if wish.sample_time is not None:
        check_positive("sample_time", wish.sample_time)
    if wish.terms is None:
        return
    check_type(wish.terms, (tuple, list), "a pair of numbers of terms, as in (9, 5)")
    if len(wish.terms) != 2:
        raise UserError(f"{option('terms', wish.terms)}: must be two numbers, as in (9, 5)")
    for count in wish.terms:
        check_whole("terms", count, FEWEST, MOST)
