"""What tables say of evaluations: fitness, merit, metrics, and what is told beside them."""

from collections.abc import Mapping, Sequence

from hfc_design.files.doubts import doubts
from hfc_design.files.scenario import Scenario
from hfc_design.objectives.judge import Judge
from hfc_design.simulation.evaluation import Evaluation
from hfc_design.simulation.repeats import TOLD, ends_told, range_told


def score_rows(judge: Judge, found: Sequence[Evaluation], form: str, none: str) -> list[list[str]]:
    """Fitness, merit and metrics, a row each; a column for each evaluation.

    A metric is written in a ``form``, as ``none`` where it has no value; a loop whose error comes
    back again and again settles never.
    """
    rows = []
    for key, title in judge.titles.items():
        rows.append([title, *(_score(x, key) for x in found)])
    for key in found[0].metrics:
        rows.append([key, *(_metric(item, key, form, none) for item in found)])
    return rows


def _metric(found: Evaluation, key: str, form: str, none: str) -> str:
    value = found.metrics[key]
    if value is not None:
        return f"{value:{form}}"
    return "never" if key.endswith("settling_time_s") and not found.diverged else none


def _score(found: Evaluation, key: str) -> str:
    """The fitness or the merit, as a range where it is chaotic."""
    if found.diverged:
        return "diverged"
    many = found.ranges.get(key)
    return range_told(many) if many else f"{getattr(found, key):.4f}"


def motion_rows(found: Sequence[Evaluation], form: str, none: str) -> list[list[str]]:
    """Of several motions the first metric, the error: a row each; a column for each evaluation."""
    rows = []
    for name, one in found[0].motions.items():
        key = next(iter(one.metrics))
        values = [item.motions[name].metrics[key] for item in found]
        cells = [none if value is None else f"{value:{form}}" for value in values]
        rows.append([f"{name} {key}", *cells])
    return rows


def notes(scenario: Scenario, rows: Mapping[str, Evaluation]) -> list[str]:
    """What has to be told beside the numbers of some designs, a line each."""
    found, own = doubts(scenario), scenario.simulation.substeps
    for name, one in rows.items():
        if one.divergence:
            tried = f", with {one.substeps} substeps too" if one.substeps > own else ""
            found.append(f"{name} diverges: {one.divergence}{tried}")
        elif one.substeps > own:
            found.append(
                f"{name} is simulated with {one.substeps} substeps, it diverges with {own}"
            )
        if one.chaotic:
            told = (key for key in scenario.judge().titles if key in one.ranges)
            ranges = [f"{key} ranges from {ends_told(one.ranges[key])}" for key in told]
            found.append(
                f"{name} is chaotic: {TOLD}, {', '.join(ranges)}; all else is of the unchanged run"
            )
    return found
