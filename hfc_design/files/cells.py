"""What a run is called in the batch that it belongs to, whose folders are called by hashes."""

from pathlib import Path
from typing import Any

from hfc_design.core.records import harmless
from hfc_design.core.texts import LARGEST_TABLE, content, decoded, json_of

#: What lies in the folder of a batch beside its runs: which cells it has.
PLAN = "batch.json"
#: A word that a reader knows a cell by, and what sets apart the runs of a group.
LABEL, SEED = "label", "run.seed"


def called(path: str | Path) -> str:
    """The label of a run, or what it sets that others do not, and its seed; "" outside a batch.

    ``path`` is that of its folder, or of a file in it.
    """
    folder = Path(path).resolve()
    folder = folder.parent if folder.is_file() else folder
    try:
        cells: Any = json_of(decoded(content(folder.parent / PLAN, LARGEST_TABLE)))["cells"]
        own = cells[folder.name]
        others = [one for one in cells.values() if one != own]
        differing = {k for k in own for one in others if k not in one or one[k] != own[k]}
    except (ValueError, KeyError, TypeError, AttributeError):  # its own reader says what is wrong
        return ""
    setting = (key for key in own if key in differing - {SEED})
    told = [f"{key.rpartition('.')[2]} {own[key]}" for key in setting]
    if LABEL in own:
        told = [str(own[LABEL])]
    if SEED in differing:
        told.append(f"seed {own[SEED]}")
    return harmless(", ".join(told))
