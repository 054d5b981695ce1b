"""Labels of the runs of a batch, whose folders are named by hashes."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from hfc_design.core.numbers import Json
from hfc_design.core.records import harmless
from hfc_design.core.texts import LARGEST_TABLE, content, decoded, json_of

#: File in the folder of a batch that lists its cells.
PLAN = "batch.json"
#: Keys of a cell: a word that names it for readers, and the seed, which differs within a group.
LABEL, SEED = "label", "run.seed"


def run_labels(cells: Mapping[str, Json]) -> dict[str, str]:
    """Return a distinct text for each cell: its label, and settings that differ among equal labels.

    An example is "spread=0.1, seed=2": a setting is named by the last part of its key if this is
    unique, and the seed comes last. A cell without a label has all settings that cells differ in.
    """
    alike: dict[str, list[Json]] = defaultdict(list)
    for cell in cells.values():
        alike[str(cell.get(LABEL, ""))].append(cell)
    alike[""] = [*cells.values()]
    same = {label: shared(inside) for label, inside in alike.items()}
    return {name: _name(cell, same[str(cell.get(LABEL, ""))]) for name, cell in cells.items()}


def shared(cells: Iterable[Json]) -> Json:
    """Return the settings that are the same in every cell."""
    first, *others = cells
    return {k: x for k, x in first.items() if all(k in cell and cell[k] == x for cell in others)}


def _name(cell: Json, same: Json) -> str:
    last = {key: key.rpartition(".")[2] for key in cell if key not in same and key != LABEL}
    short = Counter(last.values())
    parts = [str(cell[LABEL])] if LABEL in cell else []
    for key, end in sorted(last.items(), key=lambda item: item[0] == SEED):
        parts.append(f"{end if short[end] == 1 else key}={cell[key]}")
    return harmless(", ".join(parts))


def run_label(path: str | Path) -> str:
    """Return the label of the cell of a batch that a path belongs to; "" outside a batch.

    ``path`` is the run folder of the cell, or a file in it.
    """
    folder = Path(path).resolve()
    folder = folder.parent if folder.is_file() else folder
    try:
        cells: Any = json_of(decoded(content(folder.parent / PLAN, LARGEST_TABLE)))["cells"]
        return run_labels(cells)[folder.name]
    except (ValueError, KeyError, TypeError, AttributeError):  # the reader of batches reports this
        return ""
