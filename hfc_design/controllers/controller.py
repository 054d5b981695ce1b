"""What a controller is."""

from collections.abc import Callable
from typing import Any, NamedTuple

#: (gains, memory, signals) -> (command or what it is made of, memory)
Step = Callable[[Any, Any, dict[str, Any]], tuple[Any, Any]]


class Controller(NamedTuple):
    """A controller as pure functions of scalars, called once a sample::

    memory = controller.initial_memory(zero)
    command, memory = controller.step(gains, memory, signals)

    ``gains`` is the record that a search changes, ``memory`` what has to be remembered from one
    sample to the next, ``signals`` a dict of the tracking error, its rate and the plant's
    readings.
    """

    kind: str
    initial_memory: Callable[[Any], Any]
    step: Step


def summed(parts: Step) -> Step:
    """The step of a law that gives its command in parts: their sum, and what to remember."""

    def step(gains: Any, memory: Any, signals: dict[str, Any]) -> tuple[Any, Any]:
        found, memory = parts(gains, memory, signals)
        return found.command(), memory

    return step
