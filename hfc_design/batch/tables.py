"""The tables beside the page: every run, every group and every comparison, in full precision."""

import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hfc_design.batch.published import HEAD, Findings, Reproduced
from hfc_design.batch.runs import JUDGED_BY, Run, text
from hfc_design.batch.summary import Comparison, Group, quartiles
from hfc_design.core.checkpoint import write_whole
from hfc_design.core.records import UserError
from hfc_design.formats.writing import csv_text

RUNS, GROUPS, COMPARISONS, PARQUET = "runs.csv", "groups.csv", "comparisons.csv", "runs.parquet"
PUBLISHED = "published.csv"
Column = list[str | int | float | None]
QUARTILES = ("lower_quartile", "median", "upper_quartile")


def write(out: Path, found: Findings, parquet: bool) -> None:
    """Write the tables into a folder; ``parquet`` adds the runs as Parquet.

    Raises:
        RunError: the folder cannot be written.
        UserError: Parquet is asked for and pyarrow is not installed.
    """
    columns = run_columns(found.runs, found.groups)
    content = _parquet(columns) if parquet else b""  # first: nothing is written if it cannot be
    rows: dict[str, Iterable[Sequence[object]]] = {
        RUNS: [list(columns), *zip(*columns.values(), strict=True)],
        GROUPS: _group_rows(found.groups),
        COMPARISONS: _comparison_rows(found.comparisons),
    }
    if found.figures:
        rows[PUBLISHED] = [HEAD, *map(_figure_row, found.figures)]
    for name, table in rows.items():
        write_whole(out / name, csv_text(table).encode())
    if parquet:
        write_whole(out / PARQUET, content)


def run_columns(runs: Sequence[Run], groups: Sequence[Group]) -> dict[str, Column]:
    """Name -> values of all runs; None where a run has no such value."""
    group_of = {run.path: group.number for group in groups for run in group.runs}
    settings = dict.fromkeys(key for run in runs for key in run.settings)
    scores = dict.fromkeys(key for run in runs for key in run.score)
    found: dict[str, Column] = {
        "run": [run.path for run in runs],
        "group": [group_of.get(run.path) for run in runs],
        "state": [run.state for run in runs],
        "generations": [len(run.best) for run in runs],
    }
    for key in settings:
        found[key] = _of_one_type([run.settings.get(key) for run in runs])
    for key in scores:
        found[key] = [run.score.get(key) for run in runs]
    found[JUDGED_BY] = [run.judged_by or None for run in runs]
    found["reason"] = [run.reason or None for run in runs]
    return found


def medians(group: Group) -> dict[str, tuple[float, float, float]]:
    """Quartiles of each metric over the finished runs of a group that have it."""
    values: dict[str, list[float]] = {}
    for run in group.finished:
        for key, value in run.score.items():
            if value is not None:
                values.setdefault(key, []).append(value)
    return {key: quartiles(np.array(found)) for key, found in values.items()}


def _of_one_type(values: list[Any]) -> Column:
    """Numbers where all of a setting's values are, else what a reader sees of each."""
    if all(value is None or type(value) in (int, float) for value in values):
        return values
    return [None if value is None else text(value) for value in values]


def _group_rows(groups: Sequence[Group]) -> Iterable[Sequence[object]]:
    found = [medians(group) for group in groups]
    metrics = list(dict.fromkeys(key for item in found for key in item))
    keys = list(groups[0].settings) if groups else []
    head = ["group", "task", "measure", *keys, "runs", "finished"]
    yield [*head, *(f"{key}_{part}" for key in metrics for part in QUARTILES)]
    for group, item in zip(groups, found, strict=True):
        own = [group.number, group.task, group.measure, *group.settings.values(), len(group.runs)]
        told = [value for key in metrics for value in item.get(key, (None, None, None))]
        yield [*own, len(group.scores), *told]


def _comparison_rows(comparisons: Sequence[Comparison]) -> Iterable[Sequence[object]]:
    head = ["task", "measure", "group", "other_group", "runs", "other_runs", "a12", "p", "p_holm"]
    yield head
    for item in comparisons:
        first, second = item.first, item.second
        which = (first.task, first.measure, first.number, second.number)
        yield [*which, len(first.scores), len(second.scores), item.a12, item.p, item.holm]


def _figure_row(item: Reproduced) -> Sequence[object]:
    paper, simulated = item.published, item.simulated
    number = None if np.isnan(simulated) else simulated
    told = (paper.figure, paper.quantity, paper.value, number)
    return [*told, None if number is None else item.ratio, item.runs, paper.remark]


def _parquet(columns: dict[str, Column]) -> bytes:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise UserError("--parquet: needs pyarrow; pip install 'hfc-design[parquet]'") from None
    buffer = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), buffer)
    return buffer.getvalue()
