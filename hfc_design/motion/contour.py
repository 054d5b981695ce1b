"""Contour error: distance of the machine from the path, wherever the machine is along it.

The error is positive to the left of the motion. For a ``Circle`` it is the distance from the
centre less the radius, so positive outside (JK04 section 5). Lengths are in mm unless another unit
is given.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Indices, Mask, Scalar
from hfc_design.motion.paths import Path
from hfc_design.motion.program import Program
from hfc_design.motion.reversals import Glitch, glitches, undisturbed
from hfc_design.motion.samples import PathFrame, PathSamples
from hfc_design.motion.trajectories import Circle, Line, Trajectory

#: The nearest point is searched up to so many tracking errors before and after the commanded place:
#: far enough for a machine halfway around a corner of 30 deg, but not on another branch.
REACH = 4.0


def local_error(
    dx: Scalar,
    dy: Scalar,
    tx: Scalar,
    ty: Scalar,
    curvature: Scalar,
    root: Callable[[Scalar], Scalar] = lambda x: x**0.5,
) -> Scalar:
    """Return the distance from the line or circle that touches the path at the commanded place.

    It is positive to the left, and exact on lines and circles. Numbers may be arrays, or traced.

    Args:
        dx, dy: actual less commanded position.
        tx, ty: unit tangent of the path there.
        curvature: of the path there, positive to the left.
        root: function for the square root of these numbers.
    """
    f = (tx * dy - ty * dx) - 0.5 * curvature * (dx * dx + dy * dy)
    # The root is the distance from the centre over the radius; at the centre it may round below 0.
    return 2.0 * f / (1.0 + root(abs(1.0 - 2.0 * curvature * f)))


class Off(NamedTuple):
    """Deviation of a machine from its path, computed from the path at the commanded place."""

    contour: Scalar  # error; in X-Y positive to the left, else a distance
    orientation: Scalar | None  # error of the rotary axes, a distance; None: there are none
    along: Scalar  # error along the path, positive ahead


def off_path(path: PathFrame, off: Sequence[Scalar]) -> Off:
    """Return the errors of a machine whose axes are ``off`` their commanded places by so much.

    In X-Y the contour error is ``local_error``. With other axes it is the distance in X-Y-Z from
    the parabola that touches the path there; while only rotary axes move, from the parabola where
    linear axes moved last. The orientation is compared with that of the path at the machine's
    place along it. Lengths and angles are in the units of the axes.
    """
    rows = [*zip(off, path.tangent, path.bend or (0.0,) * len(off), strict=True)]
    linear = [row for row in rows if row[2] is not None]
    rotary = [(a, t) for a, t, bend in rows if bend is None]
    ahead = sum(a * t for a, t, _ in linear)
    if len(off) == 2 and not rotary:
        (x, tx, _), (y, ty, _) = linear
        return Off(local_error(x, y, tx, ty, path.curvature), None, ahead)
    along = ahead + path.only_turning * (sum(a * t for a, t in rotary) - ahead) if rotary else ahead
    away = [a - ahead * t - 0.5 * ahead * ahead * bend for a, t, bend in linear]
    turned = _length([a - along * t for a, t in rotary]) if rotary else None
    return Off(_length(away), turned, along)


def _length(vector: Sequence[Scalar]) -> Scalar:
    return sum(x * x for x in vector) ** 0.5


class Nearest(NamedTuple):
    """Points of the path that are nearest to the machine, and its error."""

    point: Floats  # (2, steps) [mm]
    error: Floats  # (steps,) contour error [mm]


@np.errstate(invalid="ignore")  # a diverged motion, or one at the centre
def nearest(trajectory: Trajectory, samples: PathSamples, actual: Floats) -> Nearest:
    """Return the nearest points and the contour error of the actual positions (2, steps) [mm].

    On a ``Circle`` the error is the distance from the centre less the radius, on a ``Line`` the
    distance to the left of the endless line. On others see ``nearest_on_path``.
    """
    if isinstance(trajectory, Circle):
        distance = np.hypot(actual[0], actual[1])
        return Nearest(
            trajectory.radius_mm * actual / np.where(distance > 0, distance, np.nan),
            distance - trajectory.radius_mm,
        )
    if isinstance(trajectory, Line):
        dx, dy = actual - samples.position
        tx, ty = samples.tangent
        error = np.asarray(local_error(dx, dy, tx, ty, samples.curvature))
        return Nearest(actual - error * np.stack([-ty, tx]), error)
    return nearest_on_path(trajectory.path, samples, actual)


@np.errstate(invalid="ignore")  # a diverged motion
def nearest_on_path(path: Path, samples: PathSamples, actual: Floats) -> Nearest:
    """Return the nearest points of the path and the distances to them, positive to the left.

    Only the path within ``REACH`` tracking errors of the commanded place counts, so that another
    branch that passes by is not taken for the one being cut. If both segments at a corner are
    equally near, the side is that of the sum of both.
    """
    off = actual - samples.position
    search_range = REACH * np.hypot(off[0], off[1])
    begin = np.clip(samples.distance - search_range, 0.0, path.knots[-1])
    end = np.clip(samples.distance + search_range, 0.0, path.knots[-1])
    last = len(path.length) - 1
    first = np.clip(np.searchsorted(path.knots, begin, side="right") - 1, 0, last)
    final = np.clip(np.searchsorted(path.knots, end, side="right") - 1, 0, last)
    best = np.full(len(begin), np.inf)
    side = np.zeros(len(begin))
    point = np.empty_like(actual)
    for turn in range(int((final - first).max(initial=0)) + 1):
        now = np.flatnonzero(first + turn <= final)
        k = first[now] + turn
        lowest = np.maximum(begin[now] - path.knots[k], 0.0)
        highest = np.minimum(end[now] - path.knots[k], path.length[k])
        s = _nearest_on(path, k, actual[:, now], lowest, highest)
        place = path.on(k, s)
        away = actual[:, now] - place.position
        gap = np.hypot(away[0], away[1])
        left = place.tangent[0] * away[1] - place.tangent[1] * away[0]
        same = np.abs(gap - best[now]) <= 1e-9 * gap
        nearer = ~same & ~(gap > best[now])  # nan stays nan
        side[now] = np.where(same, side[now] + left, np.where(nearer, left, side[now]))
        best[now] = np.where(nearer, gap, best[now])
        point[:, now] = np.where(nearer, place.position, point[:, now])
    return Nearest(point, np.where(side < 0, -best, best))


def _nearest_on(path: Path, k: Indices, actual: Floats, lowest: Floats, highest: Floats) -> Floats:
    """Return the length along segment ``k``, ``lowest`` to ``highest``, nearest to ``actual``."""
    off = actual - path.start[:, k]
    tangent, curvature = path.tangent[:, k], path.curvature[k]
    ahead = tangent[0] * off[0] + tangent[1] * off[1]
    left = tangent[0] * off[1] - tangent[1] * off[0]
    bent = curvature != 0
    safe = np.where(bent, curvature, 1.0)
    around = np.abs(2 * np.pi / safe)
    # On an arc the angle about the centre decides, counted on from the lowest length.
    turned = np.arctan2(curvature * ahead, 1.0 - curvature * left) / safe
    turned = np.mod(turned - lowest, around)
    beyond = turned - (highest - lowest)
    back = around - turned < beyond  # nearer to the lowest than to the highest length
    on_arc = np.where(back, lowest, lowest + np.minimum(turned, highest - lowest))
    return np.where(bent, on_arc, np.clip(ahead, lowest, highest))


class Contour(NamedTuple):
    """Path of a machine, and its deviation from the path."""

    trajectory: Trajectory | Program
    samples: PathSamples
    actual: Floats  # (axes, steps) [mm, deg]
    error: Floats  # (steps,) [unit]
    glitches: list[Glitch]  # errors in the unit
    undisturbed: Mask  # (steps,) see ``undisturbed``
    unit: str  # of the positions
    millimetres: float  # length of the unit [mm]
    known: Floats | None = None  # (steps,) error of the positions fed back, if they differ [unit]
    turned: Floats | None = None  # (steps,) error of the orientation (rotary axes) [deg]
    turned_glitches: list[Glitch] = []  # in ``turned``, after a rotary axis reverses [deg]

    @property
    def any_axes(self) -> bool:
        """True for a program of any axes, false for a path in X-Y alone."""
        return isinstance(self.trajectory, Program)

    @property
    def planar(self) -> Trajectory:
        """The trajectory of an X-Y machine, which can be drawn; not for a program of any axes."""
        assert isinstance(self.trajectory, Trajectory)
        return self.trajectory


def contour(
    trajectory: Trajectory,
    time: Floats,
    positions: Floats,
    unit: str,
    millimetres: float,
    seen: Floats | None = None,
) -> Contour:
    """Return the contour error of ``positions`` (2, steps) [unit], counted from the path's start.

    ``seen`` are the positions that are fed back, if they differ from ``positions``.
    """
    samples = trajectory.samples(time)

    def off(places: Floats) -> tuple[Floats, Floats]:
        actual = places * millimetres + samples.position[:, :1]
        return actual, nearest(trajectory, samples, actual).error / millimetres

    actual, error = off(positions)
    glitch_list, quiet = glitches(time, samples, error), undisturbed(time, samples.velocity)
    known = None if seen is None else off(seen)[1]
    return Contour(trajectory, samples, actual, error, glitch_list, quiet, unit, millimetres, known)


def during(contour: Contour, time: Floats, part: slice) -> Contour:
    """Return a contour with only the samples and glitches in a part of ``time`` (steps,) [s]."""
    part_time = time[part]

    def inside(all_of_them: list[Glitch]) -> list[Glitch]:
        return [glitch for glitch in all_of_them if part_time[0] <= glitch.time_s <= part_time[-1]]

    return contour._replace(
        samples=PathSamples(*(column[..., part] for column in contour.samples)),
        actual=contour.actual[:, part],
        error=contour.error[part],
        glitches=inside(contour.glitches),
        undisturbed=contour.undisturbed[part],
        known=None if contour.known is None else contour.known[part],
        turned=None if contour.turned is None else contour.turned[part],
        turned_glitches=inside(contour.turned_glitches),
    )
