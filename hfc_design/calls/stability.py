"""Gains that keep a drive stable, or the margins of a design's loop."""

from typing import TYPE_CHECKING

from hfc_design.core.arguments import check_positive
from hfc_design.core.overrides import Changes
from hfc_design.core.records import UserError
from hfc_design.stability.report import LoopMargins, StableGains, drive_of
from hfc_design.stability.stable_range import stable_range

if TYPE_CHECKING:
    from hfc_design.files.design import AnyDesign, Design  # which takes longer than all the rest
    from hfc_design.files.named_scenario import AnyScenario

#: The drive of Jee & Koren 2004, with which their controllers run.
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
    """Gains of a fuzzy controller that keep the drive K/(s (tau s + 1)) stable; margins of a loop.

    What ``hfc stability`` shows. Without a design, or with numbers of a drive, the range (Jee &
    Koren 2004, section 3), and the gains of the rule table of a design of kind flc, aflc or soflc
    in it. With a design alone the margins of its loop on its scenario: as simulated, linearised at
    rest and where each motion is slowest and fastest, for the nominal machine and a band over
    others; of a rule table on a feed drive the range too. Either shows itself as a table and has
    ``numbers()``; ``plot`` draws it.

    Args:
        design: its drive is taken unless the numbers below say another; Jee & Koren's without one.
        changes: of the design, by dotted keys.
        gain: K [(BLU/s)/unit].
        time_constant: tau [s].
        sample_time: T [s].
        scenario: whose motions and sensors count; the one that the design was made for if left out.

    Raises:
        UserError: there is no such design, numbers are given and it has no rule table, gain or
            time constant are not given for another plant than a feed drive, its loop cannot be
            linearised; a number is not allowed.
    """
    options = {"gain": gain, "time_constant": time_constant, "sample_time": sample_time}
    given = {key: value for key, value in options.items() if value is not None}
    for key, value in given.items():
        check_positive(f"--{key.replace('_', '-')}", value)
    if design is None:
        drive = PUBLISHED | given
        return StableGains(stable_range(**drive), {}, drive)
    from hfc_design.files.loop_setup import load_design
    from hfc_design.files.machine import PlantSettings  # with JAX

    loaded = load_design(design, changes)
    axes = [(axis.drive, axis.parameters) for axis in PlantSettings(**dict(loaded.plant)).each()]
    tables = loaded.kind.table_gains
    if tables and (given or any(drive.linear for drive, _ in axes)):
        mismatch = f"design {loaded.name} is for the plant {loaded.plant.name}"
        drive = drive_of(mismatch, axes, loaded.controller.sample_time_s, given)
        try:
            loop = None if given else _margins(loaded, scenario)
        except UserError:  # made for no scenario
            loop = None
        return StableGains(stable_range(**drive), tables(loaded.controller), drive, loop)
    if given:
        option = next(iter(given)).replace("_", "-")
        raise UserError(
            f"--{option}: does not apply, design {loaded.name} is judged on its own drive"
        )
    return _margins(loaded, scenario)


def _margins(design: "Design", scenario: "AnyScenario | None") -> LoopMargins:
    """On the scenario that it was made for, or another, within its tolerances."""
    from hfc_design.files.loop_setup import machine, own_scenario, with_converter
    from hfc_design.files.named_scenario import load_scenario
    from hfc_design.files.robust import RobustSettings
    from hfc_design.simulation.loop_margins import BAND, loop_margins
    from hfc_design.simulation.machines import drawn
    from hfc_design.simulation.usable import BEYOND, SPREAD

    where = load_scenario(scenario) if scenario else own_scenario(design, design.name)
    scenario = with_converter(where, design)
    robust = scenario.robust or RobustSettings(spread=SPREAD)
    parts = (robust.spread, BAND, scenario.run.seed + BEYOND, robust.tolerances)
    some, _ = drawn(machine(design, scenario), *parts, key="robust.spread")
    return loop_margins(design, scenario, some)
