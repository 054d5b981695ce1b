"""Writes what the tool prints and exports into a folder, to be compared with that of another tree.

    python tests/golden/write.py FOLDER [PART ...]     # parts: help json exports runs
    diff -r FOLDER_OF_BEFORE FOLDER

On one machine the same tree gives the same bytes; on another processor last digits differ.
"""

import os
import sys
from pathlib import Path

import click
from click.testing import CliRunner

from hfc_design.cli import main
from hfc_design.files.design import builtin_designs
from hfc_design.formats import FORMATS

SCENARIOS = {
    "c-axis-practical": "lin-lee-1999-table-1",
    "c-axis-sine": "lin-lee-1999-table-2",
    "c-axis-step": "pd-only",
    "feed-drive-circle": "jee-koren-2004-aflc",
    "feed-drive-line": "jee-koren-2004-pid",
    "five-axis-program": "lin-gai-2009-fuzzy-sliding",
    "milling-table-circle": "huang-cross-coupled",
    "milling-table-robust": "huang-pid",
    "milling-table-sine": "huang-soc",
    "positioning-stage-move": "emps-cascade",
}
KINDS = ["plant", "controller", "strategy", "objective", "scenario", "design"]
KINDS += ["reference", "metric", "format", "key"]
AT = {
    "lin-lee-1999-table-1": "error=1e-4,error_rate=0.01,deflection=1e-4,deflection_rate=0.01,"
    "spindle_velocity=0.02,rotor_velocity=0.02,previous_velocity=0.02",
    "jee-koren-2004-aflc": "error=3,previous_error=2.5,velocity=100",
}
SHORT = ["--population", "8", "--generations", "3", "--no-extend", "--quiet"]
STRATEGIES = ("cma", "l-shade", "lin-lee-1999", "nsga-ii", "race")
PAGES = ("lin-lee-1999-table-1", "jee-koren-2004-aflc", "huang-cross-coupled")
BATCH = """
name = "golden"
[set]
scenario = "feed-drive-line"
search.population = 6
search.generations = 2
[grid]
run.seed = [0, 1]
[[cells]]
label = "fast"
[[cells]]
label = "slow"
limits.command = 60.0
"""


def told(*arguments: str) -> str:
    """What a command prints, and its exit code where that is not 0."""
    done = CliRunner().invoke(main, list(arguments), terminal_width=100)
    return done.output + (f"exit code {done.exit_code}\n" if done.exit_code else "")


def helps(command: click.Command, name: str = "hfc") -> dict[str, str]:
    found = {name: told(*name.split()[1:], "-h")}
    for one, inner in getattr(command, "commands", {}).items():
        found |= helps(inner, f"{name} {one}")
    return found


def tables() -> dict[str, str]:
    found = {}
    for scenario, design in SCENARIOS.items():
        on = ["--scenario", scenario]
        many, few = ["--spread", "0.1", "--samples", "20"], ["--spread", "0.1", "--machines", "20"]
        found[f"score {scenario}"] = told("score", design, *on, "--json")
        found[f"score many {scenario}"] = told("score", design, *on, *many, "--json")
        found[f"compare {scenario}"] = told("compare", design, *on, *few, "--json")
        found[f"compare text {scenario}"] = told("compare", design, *on, *few)
        found[f"stability {scenario}"] = told("stability", design, *on, "--json")
        found[f"show {scenario}"] = told("show", "scenario", scenario, "--json")
        found[f"show text {scenario}"] = told("show", "scenario", scenario)
    for design, at in AT.items():
        found[f"explain {design}"] = told("explain", design, "--at", at, "--json")
        found[f"explain text {design}"] = told("explain", design, "--at", at)
    for kind in KINDS:
        found[f"show {kind}"] = told("show", kind)
    for design in builtin_designs():
        found[f"show design {design}"] = told("show", "design", design)
    return found


def exports(folder: Path) -> None:
    for form in FORMATS:
        for design in builtin_designs():
            place = folder / form / design
            place.parent.mkdir(parents=True, exist_ok=True)
            said = told("export", design, "--to", form, "--out", str(place))
            (folder / form / f"{design}.said").write_text(said.replace(str(folder), "FOLDER"))
            for binary in [*place.rglob("*.fmu")] if place.is_dir() else []:
                binary.unlink()  # with a compiler's bytes


def runs(folder: Path) -> None:
    """Short searches, a log and what is identified of it, pages, and a batch."""
    folder.mkdir(parents=True)
    os.chdir(folder)
    for strategy in STRATEGIES:
        told("design", "feed-drive-circle", "--preset", strategy, *SHORT, "--out", strategy)
    told("design", "c-axis-step", *SHORT, "--out", "c-axis")
    told("simulate", "emps-cascade", "--csv", "log.csv")
    told("identify", "log.csv", "--scenario", "positioning-stage-move", "--out", "identified")
    for design in PAGES:
        told("report", design, "--out", f"{design}.html")
    Path("batch.toml").write_text(BATCH)
    told("batch", "batch.toml", "--out", "batch")
    told("report", "batch")


def written(folder: Path, texts: dict[str, str]) -> None:
    folder.mkdir(parents=True)
    for name, text in texts.items():
        (folder / f"{name.replace(' ', '-')}.txt").write_text(text)


if __name__ == "__main__":
    top, parts = Path(sys.argv[1]).absolute(), sys.argv[2:] or ["help", "json", "exports", "runs"]
    os.environ["COLUMNS"] = "100"
    if "help" in parts:
        written(top / "help", helps(main))
    if "json" in parts:
        written(top / "json", tables())
    if "exports" in parts:
        exports(top / "exports")
    if "runs" in parts:
        runs(top / "runs")
