"""Circular tests of logs and of designs, from a script."""

from collections.abc import Mapping, Sequence
from math import degrees, pi
from os.path import exists, isdir
from pathlib import Path
from typing import TypeGuard

import numpy as np

from hfc_design.core.arguments import check_positive
from hfc_design.core.numbers import Floats
from hfc_design.core.texts import as_user_error
from hfc_design.files.design import AnyDesign
from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.logs.places import places
from hfc_design.logs.reading import read_log
from hfc_design.motion.circularity import (
    EXACT,
    NEAR,
    OFFSET,
    RADIUS,
    causes,
    deviations,
    full_turns,
    nominal_circle,
)
from hfc_design.motion.trajectories import Circle
from hfc_design.report.circle import FITTED, ONE, CircleTest, meant
from hfc_design.simulation.evaluating import evaluate

#: Signals of a log -> their units.
SIGNALS = {"x": "mm", "y": "mm", "x_reference": "mm", "y_reference": "mm", "time": "s"}
#: Fewest samples of a turn; turns of a simulated circle in each direction, time after them [s].
FEWEST, CYCLES, AFTER = 100, 2.0, 1.0


def circle(
    of: AnyDesign,
    scenario: AnyScenario | None = None,
    *,
    columns: Sequence[str] = (),
    radius: float | None = None,
    feed: float | None = None,
    centred: bool = False,
    limits: Mapping[str, float] | None = None,
    about: Sequence[str] = (),
) -> CircleTest:
    """Return the deviations (ISO 230-4) of a circle in a log, or of a design, and their causes.

    In a log, of any format that ``hfc identify`` reads, the first full turn of each direction
    counts, without run-up and feed-out. A design is simulated in both directions on the circle of
    its scenario. The causes are backlash, reversal spikes, servo mismatch, scale mismatch,
    squareness, radius, centre offset and vibration.

    The counterpart of ``hfc circle``. The result displays itself; ``numbers()`` are those of
    ``--json``, ``figure(page=True)`` is the page.

    Args:
        of: path of a log, or a design.
        scenario: scenario with a circle; default: the one that the design was made for.
        columns: column of x, y, x_reference, y_reference or time in a log, as in "x=qm [um]".
        radius: nominal radius [mm]; default: that of the reference, else fitted.
        feed: feed [mm/min]; default: by the times.
        centred: count F from the least-squares centre of each direction.
        limits: largest allowed G, Gb, F or D [mm], as in G=0.02.
        about: line for the page, as in "machine: VMC 3".

    Raises:
        UserError: there is no full turn with enough samples, a column is missing, or a value is
            not allowed.
    """
    for key, value in (("radius", radius), ("feed", feed)):
        if value is not None:
            check_positive(key, value)
    for key, value in (limits or {}).items():
        check_positive("limit", value, argument="limits", key=key)
    with as_user_error(getattr(of, "name", of)):
        if is_log(of):
            signals = places(read_log(of), columns, SIGNALS, ("x", "y"))
        else:
            signals = _simulated(of, scenario)
        turns, size, lasted, unknown = _turns(signals, radius)
        measured = deviations(turns, size, centred)
        if RADIUS in unknown:
            measured.pop("D", None)
        known = dict.fromkeys(meant(symbol)[0] for symbol in measured)
        if other := next((key for key in limits or () if key not in known), None):
            raise ValueError(f"limit {other}: must be of a measured deviation: {', '.join(known)}")
    feed = feed or (120.0 * pi * size / lasted if lasted else None)
    known_causes = [one for one in causes(turns, size) if one.name not in unknown]
    notes = [FITTED.format(" and ".join(unknown))] * bool(unknown) + [ONE] * (len(turns) < 2)
    return CircleTest(turns, size, feed, measured, known_causes, limits or {}, about, notes)


def _turns(
    signals: dict[str, Floats], radius: float | None
) -> tuple[dict[int, Floats], float, float, list[str]]:
    """Return full turns about their centre, radius, time of a turn [s] (or 0), what is fitted.

    Raises:
        ValueError: there is no full turn, or it has too few samples.
    """
    path = np.stack([signals["x"], signals["y"]])
    reference = [signals[name] for name in ("x_reference", "y_reference") if name in signals]
    guide, near = (np.stack(reference), EXACT) if len(reference) == 2 else (path, NEAR)
    centre, fit = nominal_circle(guide, radius, near)
    parts, longest = full_turns(guide - centre[:, None], fit, near)
    if not parts:
        size = " and ".join(f"{x:.4g} mm" for x in np.ptp(path, axis=1))
        arc = f"(got an arc of {degrees(longest):.0f} deg; X and Y move by {size})"
        known = f" with a radius of {radius:g} mm" if radius else ""
        raise ValueError(f"X and Y must go around a circle{known} by a full turn {arc}")
    if (fewest := min(part.stop - part.start for part in parts.values())) < FEWEST:
        raise ValueError(f"a turn must have at least {FEWEST} samples (got {fewest})")
    turns = {side: path[:, part] - centre[:, None] for side, part in parts.items()}
    unknown = [OFFSET] * (guide is path) + [RADIUS] * (guide is path and radius is None)
    time = signals.get("time", np.zeros(path.shape[1]))
    lasted = max(float(np.ptp(time[part])) for part in parts.values())
    return turns, radius or fit, lasted, unknown


def is_log(of: AnyDesign) -> TypeGuard[str | Path]:
    """Return whether a source is the path of a log, and not a design, its file or its folder."""
    if not isinstance(of, str | Path) or isdir(of) or Path(of).suffix == ".json":
        return False
    return exists(of) or bool(Path(of).suffix)


def _simulated(of: AnyDesign, scenario: AnyScenario | None) -> dict[str, Floats]:
    """Return the ``SIGNALS`` of a design on the circle of a scenario in both directions."""
    design = load_design(of)
    where = load_scenario(scenario) if scenario else own_scenario(design, str(of))
    for motion in where.each_motion():
        if isinstance(path := motion.path, Circle):
            break
    else:
        raise ValueError(f"needs a scenario with a circle as its path (got {where.name})")
    longer = path.model_copy(update={"direction": "both", "cycles": CYCLES})
    changes = {"reference.direction": "both", "reference.cycles": CYCLES}
    changes |= {"simulation.duration_s": longer.duration_s + AFTER}
    evaluation = evaluate(design, load_scenario(motion, changes))
    if evaluation.diverged or evaluation.contour is None:
        raise ValueError(f"diverges: {evaluation.divergence}")
    contour = evaluation.contour
    values = *contour.actual, *contour.samples.position, evaluation.time
    return dict(zip(SIGNALS, values, strict=True))
