"""Gains that keep a drive stable, or the margins of a design's loop."""

from typing import TYPE_CHECKING

from hfc_design.core.arguments import positive
from hfc_design.core.dotted import Changes
from hfc_design.core.records import UserError
from hfc_design.stability.loop_report import LoopMargins
from hfc_design.stability.report import StableGains, drive_of
from hfc_design.stability.stable_range import stable_range

if TYPE_CHECKING:
    from hfc_design.files.design import AnyDesign  # which takes longer than all the rest

#: The drive of Jee & Koren 2004, with which their controllers run.
PUBLISHED = {"gain": 28.3, "time_constant": 0.055, "sample_time": 0.01}


def stability(
    design: "AnyDesign | None" = None,
    changes: Changes = (),
    *,
    gain: float | None = None,
    time_constant: float | None = None,
    sample_time: float | None = None,
) -> StableGains | LoopMargins:
    """Gains of a fuzzy controller that keep the drive K/(s (tau s + 1)) stable; margins of a loop.

    What ``hfc stability`` shows (Jee & Koren 2004, section 3). With a design of kind flc, aflc or
    soflc also the gains of its rule table; of a linear kind, or a hierarchy on a linear part, the
    margins of its loop instead, on its own drive linearised where friction slides. Either shows
    itself as a table and has ``numbers()``; ``plot`` draws it.

    Args:
        design: its drive is taken unless the numbers below say another; Jee & Koren's without one.
        changes: of the design, by dotted keys.
        gain: K [(BLU/s)/unit].
        time_constant: tau [s].
        sample_time: T [s].

    Raises:
        UserError: there is no such design, it has neither a rule table nor a linear loop, or is
            for no feed drive and gain or time constant are not given; a number is not allowed.
    """
    options = {"gain": gain, "time_constant": time_constant, "sample_time": sample_time}
    given = {key: value for key, value in options.items() if value is not None}
    for key, value in given.items():
        positive(f"--{key.replace('_', '-')}", value)
    if design is None:
        drive = PUBLISHED | given
        return StableGains(stable_range(**drive), {}, drive)
    from hfc_design.controllers.kind import needed
    from hfc_design.files.machine import PlantSettings  # with JAX
    from hfc_design.files.pairing import load_design, open_loops

    own = load_design(design, changes)
    plant, every = PlantSettings(**dict(own.plant)), own.controller.sample_time_s
    if loops := open_loops(own, plant, own.limits):
        if given:
            option = next(iter(given)).replace("_", "-")
            raise UserError(f"--{option}: design {own.name} is judged on its own drive")
        return LoopMargins(loops, every, own.plant.name)
    lacks = "no flc, aflc or soflc, and neither pid+ff, lqr or lqi nor with a linear part"
    points = needed(own.kind.table_gains, own, lacks)(own.controller)
    axes = [(axis.drive, axis.parameters) for axis in plant.each()]
    told = f"design {own.name} is for the plant {own.plant.name}"
    drive = drive_of(told, axes, every, given)
    return StableGains(stable_range(**drive), points, drive)
