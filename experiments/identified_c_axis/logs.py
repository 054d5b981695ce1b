"""Logs of simulated C-axes, as their encoders tell them, and what such a log can tell of one."""

from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from hfc_design.files.scenario import Scenario
from hfc_design.identify.recording import Recording, recording
from hfc_design.logs.columns import Log
from hfc_design.logs.signals import signals
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.sensors import in_steps
from plants.c_axis import CAxisParameters, coefficients

HERE = Path(__file__).parent
#: The design that moves the axis.
DESIGN = "pd-only"


def log(design: str, scenario: Scenario) -> Recording:
    """The voltage, the load and what the encoders of both angles read, at every sample."""
    found = evaluate(design, scenario)
    (axis,) = found.axes
    step = scenario.sensors.of(axis.name).encoder_resolution
    readings = {
        name: in_steps(np.asarray(getattr(axis.motion.state, name)) + np.asarray(noise), step)
        for name, noise in zip(axis.drive.encoders, axis.happens.noise, strict=True)
    }
    columns = {"time": found.time, "command": axis.motion.command, "load": axis.load, **readings}
    whole = Log({name: np.asarray(column, float) for name, column in columns.items()})
    return recording(signals(whole, axis.drive, [], None), axis.drive)


def invariants(p: CAxisParameters) -> list[float]:
    """Everything of the motor that voltage and angles tell, where the current is not measured."""
    c = coefficients(p)
    pulling = c.torque_constant * c.inverse_inductance
    return [c.current_decay, pulling, c.torque_constant * c.back_emf]


def told(true: CAxisParameters, held: dict[str, float]) -> CAxisParameters:
    """What a perfect log tells of a machine if those that are ``held`` have these values.

    The others of the motor are those with which it does the same.
    """
    motor = CAxisParameters._fields[1:7]
    names, wanted = [name for name in motor if name not in held], np.log(invariants(true))

    def machine(logarithms: list[float]) -> CAxisParameters:
        values = dict(zip(names, map(float, np.exp(logarithms)), strict=True))
        return true._replace(**held, **values)

    start = np.log([getattr(true, name) for name in names])
    found = least_squares(lambda x: np.log(invariants(machine(x))) - wanted, start, xtol=1e-14)
    if not found.cost < 1e-12:
        raise ValueError(f"no motor with {held} does the same")
    return machine(found.x)
