"""Training of a neural network with the commands of a design in a motion."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from hfc_design import __version__
from hfc_design.controllers.neural.record import Lesson, Trained, begun, trained
from hfc_design.core.arguments import check_type
from hfc_design.core.numbers import Json
from hfc_design.core.overrides import Changes, set_keys
from hfc_design.core.records import UserError, checked
from hfc_design.files.design import AnyDesign, Design
from hfc_design.files.loop_setup import load_design, machine
from hfc_design.files.machine import PlantSettings, SensorSettings
from hfc_design.files.named_scenario import AnyScenario, load_scenario
from hfc_design.simulation.evaluating import evaluate

#: Most letters of a design's name, and the beginning of that of a network.
LONGEST, BEGINNING = 64, "neural-"


class Taught(NamedTuple):
    """A neural design, and how well it has learned."""

    design: Design
    training: Trained
    samples: int  # number in the lesson, of all axes
    unit: str  # of the command


def taught(
    teacher: AnyDesign,
    scenario: AnyScenario,
    network: Changes = (),
    start: AnyDesign | None = None,
    lesson: Lesson | None = None,
) -> Taught:
    """Train a network with errors and commands of all axes of ``teacher`` in ``scenario``.

    Of several motions the first is used. ``network`` sets numbers of the controller other than the
    weights, see ``NeuralDesign``; ``start`` is a neural design whose training is continued.

    Raises:
        UserError: teacher or training diverge, sensors are not ideal, or a number is not allowed.
    """
    teacher, scenario = load_design(teacher), load_scenario(scenario).each_motion()[0]
    if scenario.sensors != SensorSettings():
        why = "must be left out for training, as the readings of sensors are not recorded"
        raise UserError(f"scenario {scenario.name}: sensors: {why}")
    numbers = dict(network) if isinstance(network, dict) else set_keys(network, "network")
    evaluation = evaluate(teacher, scenario)
    if evaluation.diverged:
        fault = f"diverges on {scenario.name}, so nothing can be learned from it"
        raise UserError(f"design {teacher.name}: {fault}")
    errors = np.stack([axis.sensed()["error"] for axis in evaluation.axes], axis=1)
    commands = np.stack([axis.motion.command for axis in evaluation.axes], axis=1)
    lesson = lesson or Lesson()
    check_type(lesson, Lesson, "a lesson, as Lesson(hidden=25)")
    before = None if start is None else load_design(start).controller
    every = teacher.controller.sample_time_s
    first = begun(before, {"sample_time_s": every, **numbers}, lesson, errors, commands)
    trained_network = trained(first, errors, commands, lesson)
    origin = {"by": teacher.name, "scenario": scenario.name, "samples": errors.size}
    plant, taught = machine(teacher, scenario), {**origin, **lesson._asdict()}
    design = _design(teacher, plant, trained_network, taught)
    return Taught(design, trained_network, errors.size, evaluation.axes[0].drive.units["command"])


def _design(
    teacher: Design, plant: PlantSettings, trained_network: Trained, origin: Json
) -> Design:
    """Return the design of a trained network, for the machine of its teacher."""
    data = teacher.model_dump(mode="json", exclude={"score", "controller", "provenance"})
    data["name"] = (BEGINNING + teacher.name)[:LONGEST]
    data["plant"] = plant.in_full()
    data["controller"] = trained_network.design.model_dump(mode="json")
    data["provenance"] = {"program": f"hfc-design {__version__}", "taught": origin}
    if (scenario := teacher.provenance.get("scenario")) is not None:
        data["provenance"]["scenario"] = scenario
    return checked(Design, data, f"imitation of {teacher.name}", Path())
