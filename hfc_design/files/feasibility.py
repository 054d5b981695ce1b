"""Check that a machine can follow a scenario: with which axes, how far, how fast."""

from collections.abc import Sequence

import numpy as np

from hfc_design.core.numbers import SAME
from hfc_design.files.machine import Axis, PlantSettings, check_axes
from hfc_design.files.motions import AnyReference
from hfc_design.motion.program import Program, top_speed_fault
from hfc_design.motion.references import EachAxis, Reference
from hfc_design.motion.samples import Simulation
from hfc_design.motion.trajectories import PathReference, Trajectory, speed_fault

TOO_FAR = (
    "its positions or speeds exceed the range of numbers; one of its keys is too large or too small"
)


def check_feasible(plant: PlantSettings, reference: AnyReference, simulation: Simulation) -> None:
    """Check that a machine has the axes of a reference and can follow it; ValueError: it cannot."""
    axes = plant.machine.axes
    if isinstance(reference, Trajectory):
        _check_path(reference, plant.each(), simulation.sample_time_s)
        return
    if isinstance(reference, EachAxis):
        check_axes("reference.axes", reference.axes, axes)
        if missing := [axis for axis in axes if axis not in reference.axes]:
            raise ValueError(f"reference.axes.{missing[0]}: is missing")
    elif len(axes) > 1:
        paths = ["gcode"] if len(axes) > 2 else ["circle", "line", "polyline", "gcode"]
        raise ValueError(
            f"reference.kind = {reference.kind!r}: must be {', '.join(paths)} or per-axis with "
            f"{len(axes)} axes"
        )
    for axis in plant.each():
        _check_speed(axis, reference_of(reference, axis.name), simulation)


def reference_of(reference: AnyReference, axis: str) -> Reference:
    """Return the reference of one axis of a machine that follows no path."""
    assert not isinstance(reference, Trajectory)
    return reference.axes[axis] if isinstance(reference, EachAxis) else reference


def motion_of(
    reference: AnyReference, axes: Sequence[Axis], cycle: float
) -> Trajectory | Program | None:
    """Return the motion along the path of a reference, interpolated every ``cycle`` [s].

    None if the reference has no path.

    Raises:
        ValueError, UserError: these axes cannot follow the path.
    """
    if not isinstance(reference, Trajectory):
        return None
    try:
        return reference.on(tuple(axis.moved for axis in axes), cycle)
    except ValueError as error:
        raise ValueError(f"reference.{error}") from None


def _check_path(reference: PathReference, axes: list[Axis], cycle: float) -> None:
    key = f"reference.kind = {reference.kind!r}"
    path = motion_of(reference, axes, cycle)
    if isinstance(path, Program):
        if not path.motion.finite:
            raise ValueError(f"{key}: {TOO_FAR}")
        if fault := top_speed_fault(path):
            raise ValueError(f"reference: {fault}")
        return
    assert path is not None  # it is a trajectory in X-Y
    if len(axes) != 2:
        if len(axes) == 1:
            raise ValueError(
                f"{key}: needs a machine with two axes, X and Y; set [plant.axes.x] and "
                f"[plant.axes.y] of {axes[0].drive.name}"
            )
        one = "a program, or kind 'per-axis'"
        raise ValueError(f"{key}: must be {one} for a machine of {len(axes)} axes")
    lengths = []
    for axis in axes:
        if axis.length is None:
            raise ValueError(f"{key}: needs feed drives (got {axis.drive.name})")
        lengths.append(axis.length)
    x, y = lengths
    if x != y:
        raise ValueError(
            f"{key}: the axes of a path must count in the same length (got {x:g} and {y:g} mm)"
        )
    speeds = [axis.drive.top_speed(axis.parameters) * x for axis in axes]
    with np.errstate(all="ignore"):
        if not path.motion.finite:
            raise ValueError(f"{key}: {TOO_FAR}")
        fault = speed_fault(path, speeds)
    if fault:
        raise ValueError(f"reference: {fault}")


def _check_speed(axis: Axis, reference: Reference, simulation: Simulation) -> None:
    """Check that integration steps are short enough for the reference; ValueError: they are not."""
    with np.errstate(all="ignore"):
        samples = reference.samples(simulation.time)
    if not all(np.isfinite(x).all() for x in (samples.target, samples.reference_rate)):
        raise ValueError(f"reference.kind = {reference.kind!r}: {TOO_FAR}")
    speed = float(np.abs(samples.reference_rate).max())
    substeps = simulation.substeps
    limit = axis.drive.fastest(axis.parameters, simulation.sample_time_s / substeps)
    if speed > limit * (1.0 + SAME):
        needed = np.ceil(substeps * speed / limit * (1.0 - SAME))
        raise ValueError(
            f"simulation.substeps = {substeps}: a reference of up to "
            f"{speed:.3g} {axis.drive.units['error_rate']} needs at least {needed:.15g} with "
            "this friction and sample time"
        )
