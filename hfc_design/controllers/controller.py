"""What a controller is."""

from collections.abc import Callable
from typing import Any, NamedTuple


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
    step: Callable[[Any, Any, dict[str, Any]], tuple[Any, Any]]
