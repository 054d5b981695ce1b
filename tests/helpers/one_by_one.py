"""Designs on their own scenarios, cut short, and machines of a spread one by one."""

from hfc_design.files.loop_setup import load_design, own_scenario
from hfc_design.files.machine import PlantSettings
from hfc_design.simulation.evaluating import evaluate


def case(name, *changes, seconds=0.5):
    design = load_design(name)
    return design, own_scenario(design, name, [f"simulation.duration_s={seconds}", *changes])


def alone(design, scenario, machines, k):
    """``evaluate`` of machine ``k``, 0 the nominal one."""
    found = [{key: float(v[k]) for key, v in p._asdict().items()} for p in machines.actual]
    if len(found) == 1:
        plant = PlantSettings(name=scenario.plant.name, parameters=found[0])
    else:
        plant = PlantSettings(name=scenario.plant.name, axes={"x": found[0], "y": found[1]})
    return evaluate(design, scenario.model_copy(update={"plant": plant}))
