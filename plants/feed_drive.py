"""One axis of a milling machine's feed drive with stiction (Jee & Koren 2004, cited as JK04).

A DC servo-motor behind an amplifier with an 8-bit converter moves a table; the command counts
converter units, the position basic length-units (BLU). Friction is counted in command units.
"""

from functools import partial
from typing import Annotated, NamedTuple

import jax.numpy as jnp
import numpy as np

from plants.drive import NOT_NEGATIVE, Drive, Loads, Scalar, only_positive, units_in
from plants.sliding import Slide, slid


class FeedDriveParameters(NamedTuple):
    """Physical parameters; the defaults are the X-axis of JK04.

    Friction at V [mm/s] is the Coulomb level; below ``low_velocity`` ``start + slope V + curvature
    V^2`` is added, the start and negative viscous friction of JK04 eq. 28, signed as printed for
    each direction. With F_c and the printed K the PID has the contour errors of Fig. 12; if the
    singletons of Table 3 are doubled too, nearly all other figures agree
    (``experiments/jee_koren_2004``). With the printed singletons Fig. 10 needs K = 40 and no F_c;
    then the friction of eq. 28 alone would drive an axis near 12 mm/s.
    """

    #: K, speed of the free axis for a unit of the command
    gain: Annotated[float, "(BLU/s)/unit"] = 28.3
    time_constant: Annotated[float, "s"] = 0.055  # tau, of the free axis
    #: F_c, the same at every speed; fitted, no paper prints it
    coulomb: Annotated[float, "unit"] = 15.0
    positive_start: Annotated[float, "unit"] = 6.54  # of the friction of JK04 eq. 28 forwards
    positive_slope: Annotated[float, "unit/(mm/s)"] = -1.16  # of friction forwards over the speed
    #: of friction forwards over the speed squared
    positive_curvature: Annotated[float, "unit/(mm/s)^2"] = 0.05
    negative_start: Annotated[float, "unit"] = -6.43  # of the friction of JK04 eq. 28 backwards
    negative_slope: Annotated[float, "unit/(mm/s)"] = -1.00  # of friction backwards over the speed
    #: of friction backwards over the speed squared
    negative_curvature: Annotated[float, "unit/(mm/s)^2"] = -0.04
    low_velocity: Annotated[float, "mm/s"] = 12.0  # speed below which the polynomial acts
    #: break-away level minus sliding friction at V -> 0
    stiction_rise: Annotated[float, "unit"] = 0.0
    blu: Annotated[float, "mm"] = 0.01  # basic length-unit, a count of the encoder
    lowest_command: Annotated[float, "unit"] = -128.0  # of the converter
    highest_command: Annotated[float, "unit"] = 127.0  # of the converter


class FeedDriveState(NamedTuple):
    """State of the axis; every field a scalar."""

    position: Scalar  # [BLU]
    velocity: Scalar  # [BLU/s]


class FrictionCurve(NamedTuple):
    """Sliding friction against the speed in one direction."""

    start: Scalar  # [unit]
    slope: Scalar  # [unit/(BLU/s)]
    curvature: Scalar  # [unit/(BLU/s)^2]


class FeedDriveCoefficients(NamedTuple):
    """Quantities that a step needs of the parameters, computed once; also names of HAL pins."""

    gain: Scalar  # K [(BLU/s)/unit]
    time_constant: Scalar  # tau [s]
    coulomb: Scalar  # F_c [unit]
    positive: FrictionCurve
    negative: FrictionCurve
    low_speed: Scalar  # [BLU/s]
    stiction_rise: Scalar  # [unit]
    lowest_command: Scalar  # [unit]
    highest_command: Scalar  # [unit]


def coefficients(p: FeedDriveParameters) -> FeedDriveCoefficients:
    """Return the coefficients, for BLU/s; both friction curves become functions of the speed."""
    return FeedDriveCoefficients(
        gain=p.gain,
        time_constant=p.time_constant,
        coulomb=p.coulomb,
        positive=FrictionCurve(
            p.positive_start, p.positive_slope * p.blu, p.positive_curvature * p.blu * p.blu
        ),
        negative=FrictionCurve(
            -p.negative_start, p.negative_slope * p.blu, -p.negative_curvature * p.blu * p.blu
        ),
        low_speed=p.low_velocity / p.blu,
        stiction_rise=p.stiction_rise,
        lowest_command=p.lowest_command,
        highest_command=p.highest_command,
    )


def friction(c: FeedDriveCoefficients, direction: Scalar, speed: Scalar) -> Scalar:
    """Return sliding friction [unit] at ``speed`` [BLU/s] in ``direction``; at rest at least 0."""
    curve = FrictionCurve(
        *(jnp.where(direction > 0, a, b) for a, b in zip(c.positive, c.negative, strict=True))
    )
    return c.coulomb + jnp.where(speed < c.low_speed, at_low_speed(curve, speed), 0.0)


def at_low_speed(curve: FrictionCurve, speed: Scalar) -> Scalar:
    """Return what ``curve`` adds to the Coulomb level [unit] at ``speed`` [BLU/s] (JK04 eq. 28)."""
    return curve.start + speed * (curve.slope + speed * curve.curvature)


def step(
    c: FeedDriveCoefficients, x: FeedDriveState, command: Scalar, loads: Loads, dt: Scalar
) -> FeedDriveState:
    """Return the state ``dt`` [s] later under a constant ``command`` and ``loads``, all in units.

    Solves tau dv/dt = K (u - load - friction) - v, dp/dt = v: see ``slid``.
    """
    start, middle, end = loads
    slide = Slide(c.gain, c.time_constant, partial(friction, c), c.stiction_rise)
    return slid(slide, x, command - (start + 4.0 * middle + end) / 6.0, dt)


def accepted(c: FeedDriveCoefficients, command: Scalar) -> Scalar:
    """Return the converter's output for ``command`` [unit]: a whole unit within its limits."""
    return jnp.clip(jnp.round(command), c.lowest_command, c.highest_command)


MAY_BE_ZERO = ("coulomb", "positive_start", "low_velocity", "stiction_rise")
ANY_SIGN = ("positive_slope", "positive_curvature", "negative_slope", "negative_curvature")
_sign_fault = only_positive(
    FeedDriveParameters,
    **dict.fromkeys(MAY_BE_ZERO, NOT_NEGATIVE),
    **dict.fromkeys(ANY_SIGN, (lambda value: True, "any number")),
    negative_start=(lambda value: value <= 0, "at most 0 (Jee & Koren 2004, eq. 28)"),
    lowest_command=(lambda value: value < 0, "less than 0"),
)


def fault(changes: dict[str, float]) -> str | None:
    """Return what makes the nominal axis with ``changes`` impossible, or None.

    It is a wrong sign, or friction that would accelerate the free axis at some speed, in spite of
    the damping.
    """
    if sign_fault := _sign_fault(changes):
        return sign_fault
    p = FeedDriveParameters(**changes)
    with np.errstate(all="ignore"):  # absurd numbers may overflow, and are refused
        c = coefficients(p)
    for direction, name, curve in ((1.0, "positive", c.positive), (-1.0, "negative", c.negative)):
        with np.errstate(all="ignore"):
            speeds = c.low_speed * np.arange(1000) / 1000
            braking = c.coulomb + at_low_speed(curve, speeds) + speeds / p.gain
        if not braking.min() >= 0:
            slope, curvature = (getattr(p, f"{name}_{part}") for part in ("slope", "curvature"))
            speed = direction * p.blu * speeds[braking.argmin()]
            return (
                f"parameters.{name}_slope = {slope}: with {name}_curvature = {curvature} "
                f"must not let friction drive the axis, as it would at {speed:.3g} mm/s"
            )
    return None


FEED_DRIVE = Drive(
    name="feed-drive",
    parameters=FeedDriveParameters,
    # settings of encoder and converter, and the speed up to which the fit of the friction is valid
    exact=frozenset({"blu", "lowest_command", "highest_command", "low_velocity"}),
    fault=fault,
    units=units_in("BLU", "unit", "unit"),
    meanings={
        "command": "units of the converter, positive moves the table forwards",
        "position": "of the table, as its encoder counts",
    },
    coefficients=coefficients,
    initial_state=lambda zero: FeedDriveState(zero, zero),
    step=step,
    signals=lambda c, x: {"position": x.position, "velocity": x.velocity},
    position="position",
    velocity="velocity",
    encoders={"position": "velocity"},
    accepted=accepted,
    # the linear encoder reports the nearest whole BLU
    measured=lambda c, x: x._replace(position=jnp.round(x.position)),
    commanded=lambda reference: np.round(reference * (1.0 + 1e-9)),  # halves: not by the last bit
    millimetres=lambda p: p.blu,
    top_speed=lambda p: p.gain * max(min(p.highest_command, -p.lowest_command) - p.coulomb, 0.0),
    linear=lambda p: (p.gain, p.time_constant),
)
