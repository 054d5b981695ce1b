"""Linear laws as rule tables.

A unit with consequents on a plane is nearly a linear function of its two inputs. The units of a
tree together are then nearly a linear function of all inputs.
"""

import numpy as np

from hfc_design.controllers.hierarchical.law import memberships
from hfc_design.controllers.hierarchical.record import HierarchicalSettings, layout_of
from hfc_design.core.numbers import ARRAYS, Floats, Integers


def linear_chain(sources: Integers, slopes: Floats, unit_ranges: Floats, levels: Floats) -> Floats:
    """Return tables (n, units, 7, 7) with which n trees have ``slopes`` (n, inputs) over inputs.

    Inputs are scaled. ``sources`` (n, units, 2) are those of the trees, ``levels`` (7,) are
    consequents with which a unit passes on an input. The absolute slopes of an inner unit add up to
    ``unit_ranges`` (n, units); the unit that reads the output restores the wanted slopes.
    """
    count, units = sources.shape[:2]
    each = np.arange(count)
    tables = np.empty((count, units, len(levels), len(levels)))
    for k in range(units):
        column, row = (slopes[each, source] for source in sources[:, k].T)
        size = np.ones(count)
        if k < units - 1:
            whole = np.abs(column) + np.abs(row)
            # A unit whose slopes are 0 gives a mean of its inputs, which its reader ignores.
            idle = whole == 0.0
            size = np.where(idle, 1.0, whole / unit_ranges[:, k])
            slopes = np.column_stack([slopes, np.where(idle, 0.0, size)])
            column, row = (np.where(idle, 0.5 * unit_ranges[:, k], x) for x in (column, row))
        rises = (column / size)[:, None] * levels, (row / size)[:, None] * levels
        tables[:, k] = rises[0][:, None, :] + rises[1][:, :, None]
    return tables


def passthrough(settings: HierarchicalSettings) -> Floats:
    """Return the consequents (7,) with which a unit that uses one input best reproduces it."""
    u = np.linspace(-1.0, 1.0, 401)
    shares = np.array(memberships(ARRAYS, layout_of(settings).terms, u))
    return np.asarray(np.linalg.lstsq((shares / shares.sum(axis=0)).T, u, rcond=None)[0])
