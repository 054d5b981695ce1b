"""Warnings about scenarios that can be simulated but are probably wrong, often by a unit.

They also say how a G-code program is read where machines may differ. Each rule compares numbers of
the scenario with one another; no rule assumes how large a machine is.
"""

from collections.abc import Iterator
from math import sqrt

import numpy as np

from hfc_design.files.feasibility import reference_of
from hfc_design.files.motions import LEAST_STEPS
from hfc_design.files.scenario import Scenario
from hfc_design.motion.gcode import notes, text_of
from hfc_design.motion.trajectories import GCode
from hfc_design.objectives.tolerances import TolerancesSettings, tolerated
from hfc_design.objectives.unsettled import SWING

#: Whether a motion settles is judged by each half of its last quarter (``objectives.unsettled``),
#: in which oscillations with periods of up to SWING samples have to be visible.
LEAST_SAMPLES = int(8 * SWING)
#: Standard deviation of the error of rounding to whole steps, as a share of a step.
ROUNDING = 1.0 / sqrt(12.0)
#: Factor by which a motion must take longer than its simulation to count as cut short.
LONGER = 1.02


def plausibility_warnings(scenario: Scenario) -> list[str]:
    """Return warnings, a line each, with the key and its value; [] for a plausible scenario."""
    warnings = [*_sampled(scenario), *_read(scenario)]
    for motion in scenario.each_motion():
        each = [*_noted(motion), *_timed(motion), *_coarse(motion)]
        warnings += [f"{motion.name}: {line}" if scenario.motions else line for line in each]
    return list(dict.fromkeys(warnings))


def _sampled(scenario: Scenario) -> Iterator[str]:
    every = scenario.simulation.sample_time_s
    for axis, head in _axes(scenario):
        sensor = scenario.sensors.of(axis)
        if (
            sensor.velocity == "observer"
            and sensor.observer_hz
            and 2.0 * sensor.observer_hz * every > 1.0
        ):
            yield (
                f"sensors.{head}observer_hz = {sensor.observer_hz:g} [Hz]: is above half "
                f"the sampling rate, {0.5 / every:g} Hz, where an observer filters nothing"
            )


def _read(scenario: Scenario) -> Iterator[str]:
    """Yield a warning for each encoder step whose rounding alone exceeds the target of an error."""
    fitness = scenario.fitness.on(scenario.units)
    rows = tolerated(fitness) if isinstance(fitness, TolerancesSettings) else ()
    errors = [(one.name, most) for one, most, _ in rows if one.name.endswith("rms_error")]
    name, most = min(errors, key=lambda row: row[1], default=("", np.inf))
    for axis, head in _axes(scenario):
        step = scenario.sensors.of(axis).encoder_resolution
        if ROUNDING * step > most:
            unit = scenario.units.signals["error"]
            yield (
                f"sensors.{head}encoder_resolution = {step:g} [{unit}]: rounding alone "
                f"causes an error of {ROUNDING * step:.2g} {unit} rms; "
                f"fitness.tolerances.{name} is {most:g} {unit}"
            )


def _noted(motion: Scenario) -> Iterator[str]:
    """Yield notes on words of the motion's G-code program that machines may treat differently."""
    if isinstance(reference := motion.reference, GCode):
        yield from (f"{reference.file.name}: {line}" for line in notes(text_of(reference.file)))


def _timed(motion: Scenario) -> Iterator[str]:
    ends, steps = motion.simulation.duration_s, motion.simulation.steps
    after, path = motion.fitness.settled_after_s, motion.path
    if steps < LEAST_SAMPLES:
        yield (
            f"simulation: {ends:g} s in samples of {motion.simulation.sample_time_s:g} s "
            f"are {steps} samples; with fewer than {LEAST_SAMPLES} it cannot be judged "
            "whether a loop settles"
        )
    if after >= ends and after != type(motion.fitness).model_fields["settled_after_s"].default:
        yield (
            f"fitness.settled_after_s = {after:g} [s]: the motion ends before, after "
            f"{ends:g} s; all of it counts as settled"
        )
    each = [path] if path else [reference_of(motion.reference, axis) for axis, _ in _axes(motion)]
    takes = max(getattr(one, "duration_s", 0.0) for one in each)
    if takes > LONGER * ends:
        yield (
            f"the simulation ends after {ends:g} s of a "
            f"{'move' if path is None else 'path'} of {takes:.4g} s; what follows is not "
            "in these numbers"
        )


def _coarse(motion: Scenario) -> Iterator[str]:
    """Yield a warning for each encoder step that is large compared with the travel of its axis."""
    if not any(motion.sensors.of(axis).encoder_resolution for axis, _ in _axes(motion)):
        return
    each = zip(_axes(motion), motion.plant.each(), motion.samples().axes, strict=True)
    for (axis, head), one, axis_samples in each:
        step, way = motion.sensors.of(axis).encoder_resolution, float(np.ptp(axis_samples.target))
        if 0.0 < way < LEAST_STEPS * step:
            unit = one.drive.units["error"]
            yield (
                f"sensors.{head}encoder_resolution = {step:g} [{unit}]: the axis moves by "
                f"{way:.4g} {unit} in total, only {way / step:.3g} such steps"
            )


def _axes(scenario: Scenario) -> list[tuple[str, str]]:
    """Return the name of each axis, and the prefix of its keys in ``sensors``."""
    names = scenario.plant.machine.axes
    sensor_axes = scenario.sensors.axes
    return [(name, f"axes.{name}." if name in sensor_axes else "") for name in names]
