"""How far a machine of any axes is off the path of its program.

The contour error is the distance of the tool tip from the path in X-Y-Z, as if the rotary axes
moved neither tip nor workpiece; the error of the orientation how far these are from where they
should be at the nearest point of the path.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Indices
from hfc_design.motion.axis_path import AxisPath
from hfc_design.motion.contour import REACH, Contour
from hfc_design.motion.program import Program
from hfc_design.motion.reversals import after_reversals, undisturbed
from hfc_design.motion.samples import PathSamples

#: A degree counts as so many mm in what is near: where the tool tip hardly moves, tables decide.
DEGREE = 0.05
#: Newton's steps to the nearest point of a helix.
NEWTON = 4


class Nearest(NamedTuple):
    """The points of the path that the machine is nearest to."""

    position: Floats  # (axes, steps) [mm, deg]
    contour_error: Floats  # (steps,) [mm]
    turned: Floats | None  # (steps,) error of the orientation [deg]; None: no rotary axis


@np.errstate(invalid="ignore", over="ignore")  # a diverged motion
def nearest(program: Program, samples: PathSamples, actual: Floats) -> Nearest:
    """Of the actual places (axes, steps) [mm, deg] of a machine that should be at ``samples``.

    Only the path within ``REACH`` tracking errors of the commanded place counts, so that another
    branch that passes by is not taken for the one being cut.
    """
    path, linear = program.path, program.linear
    squares = np.where(linear, 1.0, DEGREE**2)[:, None]
    in_mm = path.linear[path.block(samples.distance)]
    off = (actual - samples.position) ** 2
    off = np.where(in_mm | ~linear[:, None], off, 0.0)
    reach = REACH * np.sqrt(np.where(in_mm, off[linear].sum(axis=0), off.sum(axis=0)))
    begin = np.clip(samples.distance - reach, 0.0, path.knots[-1])
    end = np.clip(samples.distance + reach, 0.0, path.knots[-1])
    first, final = path.block(begin), path.block(end)
    best, point = np.full(len(begin), np.inf), np.full_like(actual, np.nan)
    for turn in range(int((final - first).max(initial=0)) + 1):
        now = np.flatnonzero(first + turn <= final)
        k, here = first[now] + turn, actual[:, now]
        lowest = np.maximum(begin[now] - path.knots[k], 0.0)
        highest = np.minimum(end[now] - path.knots[k], path.length[k])
        place = path.on(k, _nearest_on(path, k, here, lowest, highest, squares)).position
        gap = (squares * (here - place) ** 2).sum(axis=0)
        nearer = ~(gap >= best[now])  # nan stays nan
        best[now] = np.where(nearer, gap, best[now])
        point[:, now] = np.where(nearer, place, point[:, now])
    away = (actual - point) ** 2
    turned = None if linear.all() else np.sqrt(away[~linear].sum(axis=0))
    return Nearest(point, np.sqrt(away[linear].sum(axis=0)), turned)


def _nearest_on(
    path: AxisPath, k: Indices, actual: Floats, lowest: Floats, highest: Floats, squares: Floats
) -> Floats:
    """Way on block ``k`` to its point between two ways that is nearest to ``actual``."""
    rate = path.rate[:, k]
    whole = np.maximum((squares * rate**2).sum(axis=0), np.finfo(float).tiny)
    s = (squares * rate * (actual - path.start[:, k])).sum(axis=0) / whole
    bent = path.turning[k] != 0.0
    if bent.any():
        s[bent] = _around(path, k[bent], actual[:, bent], lowest[bent], highest[bent])
    s = np.clip(s, lowest, highest)
    for _ in range(NEWTON * bool(bent.any())):
        at, along, bend = path.on(k, s)
        off = actual - at
        slope = (squares * along**2).sum(axis=0)
        steepness = np.maximum(slope - (squares * off * bend).sum(axis=0), 0.1 * slope)
        s = np.clip(s + (squares * off * along).sum(axis=0) / steepness, lowest, highest)
    return s


def _around(path: AxisPath, k: Indices, actual: Floats, lowest: Floats, highest: Floats) -> Floats:
    """The same on an arc, by the angle about its centre alone; it may lie beyond ``highest``."""
    plane, turning, tangent = list(path.plane), path.turning[k], path.tangent[:, k]
    off = actual[plane] - path.start[plane][:, k]
    ahead = (tangent * off).sum(axis=0)
    left = tangent[0] * off[1] - tangent[1] * off[0]
    square = (tangent**2).sum(axis=0)
    turned = np.arctan2(turning * ahead, square - turning * left) / turning
    around = 2.0 * np.pi / np.abs(turning)
    turned = np.mod(turned - lowest, around)
    beyond = turned - (highest - lowest)
    return lowest + np.where(around - turned < beyond, 0.0, turned)


def program_errors(program: Program, time: Floats, positions: Floats, unit: str) -> Contour:
    """The errors of ``positions`` (axes, steps) in units of the drives at ``time`` (steps,) [s].

    ``unit`` is that of the linear axes.
    """
    units = np.array([[axis.unit] for axis in program.axes])
    samples, actual = program.samples(time), positions * units
    found = nearest(program, samples, actual)
    first = next((axis.unit for axis in program.axes if not axis.rotary), 1.0)
    error = found.contour_error / first
    each = zip(program.axes, samples.velocity, strict=True)
    moved: dict[bool, dict[str, Floats]] = {False: {}, True: {}}
    for axis, velocity in each:
        moved[axis.rotary][axis.name] = velocity
    own = after_reversals(time, moved[False], error) if moved[False] else []
    quiet = undisturbed(time, samples.velocity)
    whole = Contour(program, samples, actual, error, own, quiet, unit, first)
    if found.turned is None:
        return whole
    turned = after_reversals(time, moved[True], found.turned)
    return whole._replace(turned=found.turned, turned_glitches=turned)
