"""Deviation of a machine of any axes from the path of its program.

The contour error is the distance of the tool tip from the path in X-Y-Z, as if the rotary axes
moved neither tip nor workpiece. The error of the orientation is the distance of the rotary axes
from their places at the point of the path that is nearest in all axes.
"""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import Floats, Indices, Mask
from hfc_design.motion.axis_path import AxisPath
from hfc_design.motion.contour import REACH, Contour
from hfc_design.motion.program import Program
from hfc_design.motion.reversals import after_reversals, undisturbed
from hfc_design.motion.samples import PathSamples

#: Length [mm] that a degree counts as in the search for the point nearest in all axes.
DEGREE = 0.05
#: Number of Newton steps to the nearest point of a helix.
NEWTON = 4


class Nearest(NamedTuple):
    """Deviation of the machine from the path."""

    contour_error: Floats  # (steps,) [mm]
    turned: Floats | None  # (steps,) error of the orientation [deg]; None: no rotary axis


class _Window(NamedTuple):
    """Part of a path to search for the nearest point: some blocks, joined without all others."""

    blocks: Indices  # (blocks,) of the path
    starts: Floats  # (blocks,) way along the joined blocks at the start of each
    first: Indices  # (steps,) index in ``blocks`` of the first block to search
    final: Indices  # (steps,) index in ``blocks`` of the last block to search
    begin: Floats  # (steps,) way along the joined blocks where the search begins
    end: Floats  # (steps,) way along the joined blocks where it ends


@np.errstate(invalid="ignore", over="ignore")  # a diverged motion
def nearest(program: Program, samples: PathSamples, actual: Floats) -> Nearest:
    """Return deviations of actual places (axes, steps) [mm, deg] from the path at ``samples``.

    Only the path within ``REACH`` tracking errors of the commanded place counts, so that another
    branch that passes by is not taken for the one being cut. Blocks that only turn do not count in
    this distance: a tip that lags behind when the tables begin to turn may be on the path still.
    """
    path, linear = program.path, program.linear
    off, blocks = actual - samples.position, [path.linear, ~path.linear]
    behind = _distance(off[linear]) if linear.any() else _distance(off)
    # In blocks that only turn, the tip rests at the end of a block that moves it.
    cut = [_window(path, some, samples.distance, REACH * behind) for some in blocks if some.any()]
    tip = _closest(path, cut[:1], actual, np.where(linear, 1.0, 0.0)[:, None])
    turned = None
    if not linear.all():
        weights = np.where(linear, 1.0, DEGREE)[:, None]
        away = REACH * _distance(weights * off)
        windows = [
            _window(path, some, samples.distance, search_range)
            for some, search_range in zip(blocks, (away, away / DEGREE), strict=True)
            if some.any()
        ]
        point = _closest(path, windows, actual, weights**2)
        turned = _distance((actual - point)[~linear])
    return Nearest(_distance((actual - tip)[linear]), turned)


def _distance(vectors: Floats) -> Floats:
    return np.asarray(np.sqrt((vectors**2).sum(axis=0)))


def _window(path: AxisPath, some: Mask, distance: Floats, search_range: Floats) -> _Window:
    """Return the window of ``some`` blocks within ``search_range`` of the way ``distance``."""
    knots = np.concatenate([[0.0], np.cumsum(np.where(some, path.length, 0.0))])
    now = path.block(distance)
    here = knots[now] + np.where(some[now], distance - path.knots[now], 0.0)
    begin, end = (np.clip(here + far, 0.0, knots[-1]) for far in (-search_range, search_range))
    blocks = np.flatnonzero(some)
    first = np.searchsorted(knots[blocks + 1], begin)
    final = np.searchsorted(knots[blocks], end, side="right") - 1
    last = len(blocks) - 1
    return _Window(
        blocks, knots[blocks], np.minimum(first, last), np.clip(final, 0, last), begin, end
    )


def _closest(path: AxisPath, windows: list[_Window], actual: Floats, squares: Floats) -> Floats:
    """Return (axes, steps) the nearest points in ``windows``; ``squares``: squared axis weights."""
    best, point = np.full(actual.shape[1], np.inf), np.full_like(actual, np.nan)
    for window in windows:
        for turn in range(int((window.final - window.first).max(initial=0)) + 1):
            now = np.flatnonzero(window.first + turn <= window.final)
            which = window.first[now] + turn
            k, here, start = window.blocks[which], actual[:, now], window.starts[which]
            lowest = np.maximum(window.begin[now] - start, 0.0)
            highest = np.minimum(window.end[now] - start, path.length[k])
            place = path.on(k, _nearest_on(path, k, here, lowest, highest, squares)).position
            gap = (squares * (here - place) ** 2).sum(axis=0)
            nearer = ~(gap >= best[now])  # nan stays nan
            best[now] = np.where(nearer, gap, best[now])
            point[:, now] = np.where(nearer, place, point[:, now])
    return point


def _nearest_on(
    path: AxisPath, k: Indices, actual: Floats, lowest: Floats, highest: Floats, squares: Floats
) -> Floats:
    """Return the way on block ``k`` to its point nearest to ``actual``, between two limits."""
    rate = path.rate[:, k]
    whole = np.maximum((squares * rate**2).sum(axis=0), np.finfo(float).tiny)
    s = (squares * rate * (actual - path.start[:, k])).sum(axis=0) / whole
    bent = path.turning[k] != 0.0
    if bent.any():
        s[bent] = _around(path, k[bent], actual[:, bent], s[bent], lowest[bent], highest[bent])
    s = np.clip(s, lowest, highest)
    for _ in range(NEWTON * bool(bent.any())):
        at, along, bend = path.on(k, s)
        off = actual - at
        slope = (squares * along**2).sum(axis=0)
        steepness = np.maximum(slope - (squares * off * bend).sum(axis=0), 0.1 * slope)
        s = np.clip(s + (squares * off * along).sum(axis=0) / steepness, lowest, highest)
    return s


def _around(
    path: AxisPath, k: Indices, actual: Floats, along: Floats, lowest: Floats, highest: Floats
) -> Floats:
    """Return the way on an arc nearest to ``actual`` in angle; it may exceed ``highest``.

    Of several turns that of the way ``along`` is taken, the nearest in the axes that do not turn.
    """
    plane, turning, tangent = path.plane[:, k], path.turning[k], path.tangent[:, k]
    off = actual[plane, np.arange(len(k))] - path.start[plane, k]
    ahead = (tangent * off).sum(axis=0)
    left = tangent[0] * off[1] - tangent[1] * off[0]
    square = (tangent**2).sum(axis=0)
    turned = np.arctan2(turning * ahead, square - turning * left) / turning
    around = 2.0 * np.pi / np.abs(turning)
    turned = np.mod(turned - lowest, around)
    beyond = turned - (highest - lowest)
    turns = np.minimum(np.round((along - lowest - turned) / around), np.floor(-beyond / around))
    turned = np.where(around - turned < beyond, 0.0, turned)
    return lowest + turned + around * np.maximum(turns, 0.0)


def program_errors(program: Program, time: Floats, positions: Floats, unit: str) -> Contour:
    """Return the errors of ``positions`` (axes, steps) [units of drives] at ``time`` (steps,) [s].

    ``unit`` is that of the linear axes.
    """
    units = np.array([[axis.unit] for axis in program.axes])
    samples, actual = program.samples(time), positions * units
    distances = nearest(program, samples, actual)
    first = next((axis.unit for axis in program.axes if not axis.rotary), 1.0)
    error = distances.contour_error / first
    each = zip(program.axes, samples.velocity, strict=True)
    moved: dict[bool, dict[str, Floats]] = {False: {}, True: {}}
    for axis, velocity in each:
        moved[axis.rotary][axis.name] = velocity
    glitch_list = after_reversals(time, moved[False], error) if moved[False] else []
    quiet = undisturbed(time, samples.velocity)
    whole = Contour(program, samples, actual, error, glitch_list, quiet, unit, first)
    if distances.turned is None:
        return whole
    turned = after_reversals(time, moved[True], distances.turned)
    return whole._replace(turned=distances.turned, turned_glitches=turned)
