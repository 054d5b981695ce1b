"""Every search strategy by its name: the files in ``strategies``, and what users add."""

from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Annotated, Any

from pydantic import SerializeAsAny

from hfc_design.core.plugins import Group, chosen, found_in, lacking
from hfc_design.core.records import UserError
from hfc_design.search import strategies
from hfc_design.search.strategy import Searcher, Strategy, StrategySettings, Task


def _fault(strategy: Strategy) -> str | None:
    """What a strategy lacks, in a line; None if nothing that is seen at once."""
    if not getattr(strategy.state, "_fields", ()):
        return "state has to be a NamedTuple class"
    return lacking(strategy, ("make", "fault"), StrategySettings)


STRATEGIES: Group[Strategy] = Group(
    "strategy",
    Strategy,
    "hfc_design.strategies",
    found_in(strategies, "STRATEGY"),
    fault=_fault,
)
#: The ``[search]`` of a scenario.
SearchSettings = Annotated[
    SerializeAsAny[StrategySettings], chosen(STRATEGIES, "settings", "preset", default="race")
]


def searcher(settings: StrategySettings, task: Task) -> Searcher:
    """The strategy that ``settings`` describe, at work on a task.

    Raises:
        UserError: it is a user's own and lacks something.
    """
    strategy = STRATEGIES.get(settings.preset)
    if strategy.name in STRATEGIES.built_in:
        return strategy.make(settings, task)
    found = _called(strategy, "make", strategy.make, settings, task)
    own: dict[str, Any] = {k: getattr(found, k, None) for k in ("start", "ask", "tell")}
    if missing := [part for part, function in own.items() if not callable(function)]:
        raise UserError(f"strategy {strategy.name!r}: what it makes has no {missing[0]}")
    watched: Any = {part: partial(_called, strategy, part, x) for part, x in own.items()}
    return SimpleNamespace(**watched)


def _called(strategy: Strategy, part: str, function: Callable[..., Any], *given: Any) -> Any:
    """What a user's own function gives; what it lacks or does wrong becomes a line."""
    try:
        found = function(*given)
        if part in ("start", "ask"):
            _ = found[1].population  # which is scored
        elif part == "tell" and not isinstance(found, strategy.state):
            raise TypeError(f"tell gave no {strategy.state.__name__}")
    except UserError:
        raise
    except Exception as error:
        told = f"{type(error).__name__}: {(str(error).splitlines() or [''])[0]}"
        line = f"strategy {strategy.name!r} cannot search: {part}: {told}"
        raise UserError(line) from error
    return found
