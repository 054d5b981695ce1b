"""A run of the C-axis with a random hierarchy of five inputs, and what it is made of."""

import numpy as np

from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.genome import Hierarchies
from hfc_design.files.design import Design
from hfc_design.search.loop import Archive, History, Search

INPUTS = [
    "error",
    "error_rate",
    "deflection",
    "deflection_rate",
    "spindle_velocity",
    "previous_spindle_velocity",
]
HOSTILE = '<script>alert("1")</script> & <img src=x>'


def design(inputs, tree=0):
    """A design with random rule tables and one of the trees of that many inputs."""
    random = np.random.default_rng(inputs)
    units = hierarchy.trees(inputs)[tree]
    sources = INPUTS[:inputs] + [f"unit-{unit.heap_id}" for unit in units]
    labels = [f"f{k}" for k in range(1, 8)]
    return Design.model_validate(
        {
            "name": "random",
            "plant": {"name": "c-axis", "parameters": {}},
            "controller": {
                "kind": "pd+hierarchical-fuzzy",
                "sample_time_s": 0.001,
                "pd": {"kp": 758.0, "kd": 743.0},
                "inputs": [{"name": name, "scale": 10.0} for name in INPUTS[:inputs]],
                "output_scale": 10.0,
                "terms": [
                    {"label": label, "centre": centre, "half_width": 0.0, "rate": 32.0}
                    for label, centre in zip(labels, np.linspace(-1, 1, 7).tolist(), strict=True)
                ],
                "units": [
                    {
                        "id": unit.heap_id,
                        "column_input": sources[unit.column],
                        "row_input": sources[unit.row],
                        "consequents": random.normal(size=(7, 7)).tolist(),
                    }
                    for unit in units
                ],
            },
            "provenance": {"program": "hfc-design 0", "note": HOSTILE},
        }
    )


def finished(inputs):
    """A search that has tried only some of the trees."""
    trees = len(hierarchy.trees(inputs))
    score = np.where(np.arange(trees) < 12, np.arange(trees) * 10.0, -np.inf)
    population = Hierarchies(
        np.arange(trees),
        np.ones((trees, 2)),
        np.ones((trees, inputs)),
        np.zeros((trees, inputs - 1, 7, 7)),
    )
    history = History(
        np.array([5.0, 50.0]), np.array([0.0, 7.0]), np.array([70, 3]), np.array([3, 2])
    )
    return Search(2, None, Archive(population, score), history)
