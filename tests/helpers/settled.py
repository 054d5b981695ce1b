"""What is measured of a nominal machine for being called stable."""

import numpy as np

from hfc_design.files.loop_setup import controller_of, with_converter
from hfc_design.simulation import population
from hfc_design.simulation.closed_loop import closed_loop
from hfc_design.simulation.stability_criteria import STABILITY, instabilities, measuring


def of_nominal(design, scenario):
    """Of the nominal machine ``STABILITY`` and whether it is stable, in float64."""
    scenario = with_converter(scenario, design)
    controller, gains = controller_of(design, scenario)
    loop = measuring(closed_loop(scenario, controller))
    machines = population.one_machine(scenario.plant.values())
    judged = population.scores(loop, machines, [scenario.samples()], gains, np.float64)
    stable = ~np.logical_or.reduce(
        [*instabilities(judged.values[0], judged.failed[0], [scenario]).values()]
    )
    names = [one.name for one in STABILITY]
    return dict(zip(names, judged.values[0, 0, 0, -3:], strict=True)), bool(stable[0, 0])
