"""Design a controller for the C-axis, examine it, and export it to other programs.

In this folder::

    python 01_design_and_export.py [GENERATIONS] [FOLDER]

With all 200 generations this takes about a minute on two cores.
"""

import sys
from pathlib import Path

import hfc_design.api as hfc


def main(generations: int = 60, folder: str = "runs/example") -> None:
    """Design, score, draw and export."""
    # A built-in scenario, a TOML file, or a dict; any key can be changed by its dotted name.
    scenario = hfc.load_scenario("c-axis-ramp-cutting", {"search.generations": generations})

    # Without a folder nothing is written. With one it holds the whole run and a report, and a
    # script that was stopped goes on where it was.
    found = hfc.design(scenario, on_generation=progress)
    print(f"fitness {found.evaluation.fitness:.4g} where it was designed")

    # The same controller on another motion, beside a published one.
    sine = hfc.load_scenario("c-axis-sine")
    published = hfc.load_design("lin-lee-1999-table-1")
    for design in (found.design, published):
        metrics = hfc.evaluate(design, sine).metrics
        print(f"{design.name}: rms error {metrics['rms_error_rad']:.3g} rad on a sine")

    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    hfc.export(found.design, "json", place / "design.json")
    hfc.export(found.design, "csv", place / "tables")
    hfc.plot(found.evaluation, place / "motion.png")
    print(f"written to {place}")


def progress(search: hfc.Search) -> None:
    """Now and then a line about the search."""
    if search.generation % 20 == 0:
        print(f"generation {search.generation}: best {search.history.best[-1]:.4g}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]), *sys.argv[2:3])
