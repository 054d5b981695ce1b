"""What the adaptation of a feed drive's controller has come to at the end of a motion."""

import numpy as np

from hfc_design.controllers.flc.record import AflcDesign, FuzzyRecord
from hfc_design.files.design import Design
from hfc_design.files.machine import SensorSettings
from hfc_design.files.scenario import Scenario
from hfc_design.runtime import Controller
from hfc_design.simulation.evaluation import AxisMotion, Evaluation
from plants import PLANTS


def at_the_end(design: Design, own: Evaluation, scenario: Scenario) -> dict[str, FuzzyRecord]:
    """The controller of each axis at the end of the motion, if it adapts.

    Stepped over what the axis measured, some 0.1 ms a sample; not with sensors of the scenario's
    own, whose readings are not recorded.
    """
    ideal = scenario.sensors == SensorSettings()
    if not isinstance(design.controller, AflcDesign) or own.diverged or not ideal:
        return {}
    names = [name.upper() for name in scenario.plant.axes] or ["the axis"]
    axes = zip(names, scenario.plant.values(), own.axes, strict=True)
    return {name: _after(design, parameters, axis) for name, parameters, axis in axes}


def _after(design: Design, parameters: object, axis: AxisMotion) -> FuzzyRecord:
    plant = PLANTS[design.plant.name]
    fixed = plant.coefficients(parameters)
    seen = plant.measured(fixed, axis.motion.state)
    error = axis.reference - np.asarray(getattr(seen, plant.position))
    velocity = np.asarray(getattr(seen, plant.velocity))
    controller = Controller(design)
    for e, v in zip(error.tolist(), velocity.tolist(), strict=True):
        controller.step({"error": e, "velocity": v})
    return controller.adapted()
