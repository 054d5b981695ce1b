"""WebAssembly of a whole closed loop: the simulator's own sample, traced and printed.

All numbers are arguments: those of the loop (limits, sensors, delays), of the machine, of the
controller. So the same code simulates every machine and every change of a number. Its functions get
the addresses of arrays, in which two machines are side by side where ``LANES`` says so::

    prepare(loop, parameters, fixed)      // coefficients of two machines
    begin(loop, fixed, gains, start, state)
    sample(loop, nominal, fixed, every, gains, state, row)      // once for each row
    judge(loop, state, values)      // what the judge measures: objectives, then metrics
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import numpy as np

from hfc_design.codegen.nodes import TraceError
from hfc_design.codegen.wasm import Argument, Body, module
from hfc_design.core.numbers import Floats, Gains
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.loop_setup import controller_of, machine
from hfc_design.files.scenario import Scenario
from hfc_design.motion.samples import Samples
from hfc_design.simulation.closed_loop import (
    Loop,
    closed_loop,
    first_monitor,
    monitored,
    next_state,
    start,
)
from hfc_design.simulation.flattening import Code, joined
from hfc_design.simulation.following import columns

#: Arrays in which two machines are side by side.
LANES = ("parameters", "fixed", "state", "values")


class LoopCode(NamedTuple):
    """A closed loop in WebAssembly, with the numbers of the nominal machine."""

    module: bytes  # functions ``prepare``, ``begin``, ``sample`` and ``judge``
    loop: list[float]
    parameters: list[float]
    gains: list[float]
    every: float  # [s]
    start: list[float]  # states before the first sample
    sizes: dict[str, int]  # of the arrays ``fixed``, ``state`` and ``values``
    metrics: list[str]  # names of ``values``
    commands: int  # place of the first command in the state; those of other axes follow
    places: list[int]  # of the position of each axis in the state
    references: list[int]  # places of the reference of each axis in a row


def loop_code(design: Design, scenario: Scenario) -> LoopCode:
    """Return the code of the closed loop of a design on a scenario.

    Raises:
        UserError: design and scenario do not fit, or there is no code for what a user's law or
            machine does.
    """
    closed, gains = loop_of(design, scenario)
    code, numbers = closed.apart
    parameters = tuple(machine(design, scenario).values())
    law = jax.tree.map(_nested, gains)
    motion = scenario.each_motion()[0]
    samples = motion.samples()
    row = columns(samples, motion.simulation.steps)
    fixed = jax.eval_shape(closed.coefficients, parameters)
    parts = _functions(code)
    state = jax.eval_shape(parts["begin"][0], numbers, fixed, law, samples.start)
    each: dict[str, Any] = {"loop": numbers, "nominal": parameters, "parameters": parameters}
    each |= {"fixed": fixed, "every": 0.0, "gains": law, "state": state, "row": row}
    each |= {"values": jax.eval_shape(parts["judge"][0], numbers, state), "start": samples.start}
    try:
        code_of = module({name: _body(each, *part) for name, part in parts.items()})
    except TraceError as error:
        raise UserError(f"no code of this loop: {error}") from None
    places = jax.tree.unflatten(jax.tree.structure(state), range(len(jax.tree.leaves(state))))
    given = jax.tree.unflatten(jax.tree.structure(row), range(len(jax.tree.leaves(row))))
    pairs = zip(closed.machine.drives, places[0].states, strict=True)
    return LoopCode(
        module=code_of,
        loop=numbers_of(numbers),
        parameters=numbers_of(parameters),
        gains=numbers_of(law),
        every=float(samples.sample_time),
        start=numbers_of(samples.start),
        sizes={name: len(jax.tree.leaves(each[name])) for name in ("fixed", "state", "values")},
        metrics=[
            *(x.name for x in closed.judge.objectives),
            *(x.name for x in closed.judge.measured),
        ],
        commands=places[0].commands[0],
        places=[getattr(one, drive.position) for drive, one in pairs],
        references=[one.reference for one in given.axes],
    )


def _functions(code: Code) -> dict[str, tuple[Callable[..., Any], str, str]]:
    """Return the functions of a loop: each with its arguments, and the array that it writes."""

    def prepare(numbers: Any, parameters: Any) -> Any:
        return joined(code, numbers).coefficients(parameters)

    def begin(numbers: Any, fixed: Any, law: Any, started: Any) -> Any:
        loop = joined(code, numbers)
        machine = start(loop, fixed, 0.0, started, law)
        return machine, first_monitor(loop, 0.0, machine)

    def sample(
        numbers: Any, nominal: Any, fixed: Any, every: Any, law: Any, state: Any, row: Any
    ) -> Any:
        loop, (before, watch) = joined(code, numbers), state
        after = next_state(loop, nominal, fixed, every, law, before, row)
        return after, monitored(loop, fixed, every, before, after.commands, watch, row)[0]

    def judge(numbers: Any, state: Any) -> Any:
        parts, sums = joined(code, numbers).judge, state[1].sums
        values = parts.values(sums[: len(parts.objectives)])
        pairs = zip(parts.measured, sums[len(values) :], strict=True)
        return [*values, *(one.value(totals) for one, totals in pairs)]

    return {
        "prepare": (prepare, "loop parameters", "fixed"),
        "begin": (begin, "loop fixed gains start", "state"),
        "sample": (sample, "loop nominal fixed every gains state row", "state"),
        "judge": (judge, "loop state", "values"),
    }


def loop_of(design: Design, scenario: Scenario) -> tuple[Loop, Gains]:
    """Return the loop that ``loop_code`` prints, and the gains of the design.

    It lacks metrics that need a second machine.
    """
    controller, gains = controller_of(design, scenario)
    closed = closed_loop(scenario, controller)
    alone = tuple(one for one in closed.judge.measured if not one.doubled)
    return closed._replace(judge=closed.judge._replace(measured=alone)), gains


def rows(samples: Samples, steps: int) -> Floats:
    """Return the numbers of each row (steps, numbers), in the order of the code's ``row``."""
    return np.stack(jax.tree.leaves(columns(samples, steps)), axis=1)


def _nested(leaf: Any) -> Any:
    """Return a leaf (..., 1 individual) as nested tuples of numbers.

    ``stepping.nested`` does that for JAX, which compiles a program for each number outside of one.
    """

    def tuples(x: Any) -> Any:
        return tuple(map(tuples, x)) if isinstance(x, list) else x

    return tuples(np.asarray(leaf)[..., 0].tolist())


def numbers_of(tree: Any) -> list[float]:
    """Return the numbers of a tree, of single machines and controllers."""
    return [float(np.asarray(x)) for x in jax.tree.leaves(tree)]


def _body(each: dict[str, Any], function: Callable[..., Any], given: str, target: str) -> Body:
    """Return the code of a function of some arguments; ``target``: array that it writes."""
    names, places, texts = given.split(), dict[str, tuple[str, int]](), []
    for name in names:
        leaves, structure = jax.tree.flatten(each[name])
        places |= {f"{name}[{k}]": (name, k) for k in range(len(leaves))}
        texts.append(jax.tree.unflatten(structure, [f"{name}[{k}]" for k in range(len(leaves))]))

    def named(results: Any) -> dict[tuple[str, int], Any]:
        return {(target, k): x for k, x in enumerate(jax.tree.leaves(results))}

    arguments = [Argument(name, name in LANES) for name in dict.fromkeys([*names, target])]
    return Body(function, texts, arguments, places, named)
