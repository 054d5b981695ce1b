"""References as samples, before a drive makes steps of them."""

from hfc_design.core.shapes import Floats
from hfc_design.motion.references import Reference
from hfc_design.motion.samples import AxisSamples, PathFrame
from hfc_design.motion.trajectories import Trajectory


def axis_samples(reference: Reference, time: Floats) -> AxisSamples:
    """One axis that follows ``reference`` at ``time`` (steps,) [s]."""
    place, rate = reference.at(time), reference.rate(time)
    return AxisSamples(place, rate, None, None, place, reference.acceleration_at(time))


def path_samples(
    path: Trajectory, time: Floats, length: float | None
) -> tuple[list[AxisSamples], PathFrame]:
    """Both axes of a path, and the path; a unit of the positions has ``length`` [mm]."""
    assert length is not None  # the scenario has been checked
    way = path.samples(time)
    target = (way.position - way.position[:, :1]) / length  # the machine starts where it stands
    each = zip(target, way.velocity / length, way.acceleration / length, strict=True)
    axes = [AxisSamples(place, rate, None, None, place, change) for place, rate, change in each]
    return axes, PathFrame(way.tangent[0], way.tangent[1], way.curvature * length)
