"""Gains that keep a drive stable, and stability margins of a design's loop."""

from typing import TYPE_CHECKING

from hfc_design.core.arguments import check_positive
from hfc_design.core.overrides import Changes
from hfc_design.core.records import UserError, option
from hfc_design.stability.report import LoopMargins, StableGains, drive_of
from hfc_design.stability.stable_range import stable_range

if TYPE_CHECKING:
    from hfc_design.files.design import AnyDesign, Design  # takes longer to import than the rest
    from hfc_design.files.named_scenario import AnyScenario

#: Drive of Jee & Koren 2004, on which their controllers run.
PUBLISHED = {"gain": 28.3, "time_constant": 0.055, "sample_time": 0.01}


def stability(
    design: "AnyDesign | None" = None,
    changes: Changes = (),
    *,
    gain: float | None = None,
    time_constant: float | None = None,
    sample_time: float | None = None,
    scenario: "AnyScenario | None" = None,
) -> StableGains | LoopMargins:
    """Return the gains that keep the drive K/(s (tau s + 1)) stable, or the margins of a loop.

    Without a design, the result is the range of stable gains of a drive (Jee & Koren 2004, section
    3). With a design and parameters of a drive, it also says where the gains of the design's rule
    table (kind flc, aflc or soflc) are in this range. With a design alone, the result has gain,
    phase and delay margin, largest sensitivity, bandwidth and compliance of the design's loop on
    its scenario: as simulated, linearised at rest and where each motion is slowest and fastest, for
    the nominal machine and as a band over other machines; for a rule table on a feed drive it
    includes the range too.

    The counterpart of ``hfc stability``. Both kinds of result display themselves as a table and
    have ``numbers()``; ``plot`` draws them.

    Args:
        design: design whose drive is used unless the parameters below override it; default: the
            drive of Jee & Koren.
        changes: changes to the design, by dotted keys.
        gain: gain K [(BLU/s)/unit]; default: the design's, or 28.3.
        time_constant: time constant tau [s]; default: the design's, or 0.055.
        sample_time: sample time T [s]; default: the design's, or 0.01.
        scenario: scenario with the motions and sensors of the loop; default: the one that the
            design was made for.

    Raises:
        UserError: the design does not exist; parameters are given for a design without rule table;
            gain or time constant are missing for a plant that is not a feed drive; the loop cannot
            be linearised; or a number is out of range.
    """
    options = {"gain": gain, "time_constant": time_constant, "sample_time": sample_time}
    given = {key: value for key, value in options.items() if value is not None}
    for key, value in given.items():
        check_positive(key, value)
    if design is None:
        if changes:
            raise UserError(f"{option('change', argument='changes')}: needs a design")
        drive = PUBLISHED | given
        return StableGains(stable_range(**drive), {}, drive)
    from hfc_design.files import loop_setup, machine  # with JAX

    loaded = loop_setup.load_design(design, changes)
    plant = machine.PlantSettings(**dict(loaded.plant))
    axes = [(axis.drive, axis.parameters) for axis in plant.each()]
    tables = loaded.kind.table_gains
    if tables and (given or any(drive.linear for drive, _ in axes)):
        mismatch = f"design {loaded.name} is for the plant {loaded.plant.name}"
        drive = drive_of(mismatch, axes, loaded.controller.sample_time_s, given)
        try:
            loop = None if given else _margins(loaded, scenario)
        except UserError:  # such as a design made for no scenario
            loop = None
        return StableGains(stable_range(**drive), tables(loaded.controller), drive, loop)
    if given:
        why = f"does not apply, design {loaded.name} is judged on its own drive"
        raise UserError(f"{option(next(iter(given)))}: {why}")
    return _margins(loaded, scenario)


def _margins(design: "Design", scenario: "AnyScenario | None") -> LoopMargins:
    """Return margins on ``scenario``, or on that of the design, with a band over its tolerances."""
    from hfc_design.files import loop_setup, named_scenario
    from hfc_design.simulation import loop_margins, usable

    known = scenario and named_scenario.load_scenario(scenario)
    where = known or loop_setup.own_scenario(design, design.name)
    where = loop_setup.with_converter(where, design)
    some = usable.unseen(design, where, loop_margins.BAND)
    return loop_margins.loop_margins(design, where, some)
