"""One step of a controller that commands a whole machine: all axes at once."""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hfc_design.controllers.controller import PathView
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import axes_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import code
from hfc_design.motion.contour import local_error
from hfc_design.runtime import Machine
from hfc_design.simulation.evaluating import evaluate

LOOP = """#include "{name}.h"
typedef struct {{
    {name}_inputs axes[{name}_AXES];
    {path}
}} sample;
void run(int count, const sample *samples, {name}_real *commands)
{{
    {name}_state state;
    {name}_init(&state);
    for (int i = 0; i < count; i++) {{
        {name}_step(&state, samples[i].axes, {given}&commands[i * {name}_AXES]);
    }}
}}
"""


def moments(design: Design, scenario: str) -> list[tuple[dict[str, dict[str, float]], Any]]:
    """What the controller saw at every sample of a closed loop: signals of each axis, the path."""
    found = load_scenario(scenario)
    told = {axis.name: axis.sensed() for axis in evaluate(design, found).axes}
    path = found.samples().path

    def seen() -> Iterator[tuple[dict[str, dict[str, float]], Any]]:
        for k in range(found.simulation.steps):
            now = {axis: {key: float(x[k]) for key, x in own.items()} for axis, own in told.items()}
            if not design.kind.path:
                yield now, None
                continue
            tangent = tuple(float(x[k]) for x in path.tangent)
            errors = (-now[axis]["error"] for axis in axes_of(design))
            off = local_error(*errors, *tangent, bent := float(path.curvature[k]))
            yield now, PathView(tangent, bent, float(off))

    return list(seen())


def expected(design: Design, samples: list[Any]) -> tuple[np.ndarray, float]:
    """Commands (samples, axes) of the Python runtime, and the seconds of a step."""
    machine = Machine(design, axes_of(design))
    begun = time.perf_counter()
    found = [list(machine.step(*sample).values()) for sample in samples]
    return np.array(found), (time.perf_counter() - begun) / len(samples)


def rows(design: Design, samples: list[Any]) -> np.ndarray:
    """The same samples as ``LOOP`` reads them, a row each."""
    names = list(code.signals(design))

    def row(told: dict[str, dict[str, float]], path: PathView | None) -> list[float]:
        own = [told[axis][name] for axis in axes_of(design) for name in names]
        return own if path is None else [*own, *path.tangent, path.curvature, path.contour_error]

    return np.array([row(*sample) for sample in samples])


def loop(folder: Path, name: str) -> str:
    """The C around the exported step."""
    path = f"{name}_path" in (folder / f"{name}.h").read_text(encoding="ascii")
    own = {"path": f"{name}_path path;", "given": "&samples[i].path, "}
    return LOOP.format(name=name, **(own if path else {"path": "", "given": ""}))
