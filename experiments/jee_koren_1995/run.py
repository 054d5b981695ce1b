"""The figures and tables of Jee & Koren 1995 (JK95), simulated; see README.md beside this file.

Run from the root of the repository: ``.venv/bin/python -m experiments.jee_koren_1995.run``.
"""

from pathlib import Path
from typing import Any

import click

from experiments.shared import Cycles, Row, changed, curves, cycles, markdown, run
from experiments.shared import write_tables as write
from hfc_design.evaluate import load_design
from hfc_design.pictures.plots import save
from hfc_design.rulebase import Design

HERE = Path(__file__).parent
FLC, SOFLC, PID = "jee-koren-2004-flc", "jee-koren-1995-soflc", "jee-koren-2004-pid"
AFLC = "jee-koren-2004-aflc"
#: JK95 prints RMS errors of the cycles 1, 2, 3 [BLU]: contour, or the axial error of X.
AXIAL = {"SOFLC": (3.31, None, 1.82), "FLC": (6.36, None, 6.08)}
FIG_4 = {"SOFLC": (1.39, 1.24, 1.23), "FLC": (1.89, 1.93, 1.87)}
TABLE_1 = {"SOFLC": (1.35, 1.45, 1.44), "FLC": (1.60, 1.56, 1.59)}
TABLE_2_WITHOUT, TABLE_3_WITHOUT = (1.49, 1.50, 1.50), (1.06, 1.21, 1.21)


def fast(out: Path) -> list[Row]:
    """Figs. 3 and 4, Table 2: circle at 0.754 m/min."""
    found = {"FLC": run(FLC, HERE / "circle.toml"), "SOFLC": run(SOFLC, HERE / "circle.toml")}
    last = slice(2 * len(found["FLC"].time) // 3, None)
    panels = {
        "axial error X [BLU]": {k: item.axes[0].motion.error[last] for k, item in found.items()},
        "contour error [BLU]": {k: item.contour.error[last] for k, item in found.items()},
    }
    levels = {"axial error X [BLU]": {"RMS of the SOFLC in the paper": 1.82}}
    save(curves(found["FLC"].time[last], panels, levels), out)
    rows = []
    for name, item in found.items():
        own = cycles(item)
        rows += _rows("3", f"{name}: axial RMS", AXIAL[name], own.axial)
        rows += _rows("4", f"{name}: contour RMS", FIG_4[name], own.contour)
    easy = cycles(run(SOFLC, HERE / "circle-frictionless.toml"))
    rows += _rows("Table 2", "SOFLC without friction: contour RMS", TABLE_2_WITHOUT, easy.contour)
    pid = cycles(run(PID, HERE / "circle.toml"))
    ratio = pid.contour[-1] / cycles(found["SOFLC"]).contour[-1]
    return [*rows, Row("7", "0.754 m/min: contour RMS, PID / SOFLC", 2.6, ratio, "real machine")]


def slow() -> list[Row]:
    """Tables 1 and 3: circle at 0.377 m/min."""
    found = {name: cycles(run(name, HERE / "slow-circle.toml")) for name in (FLC, SOFLC, PID)}
    easy = cycles(run(SOFLC, HERE / "slow-circle-frictionless.toml"))
    ratio = found[PID].contour[-1] / found[SOFLC].contour[-1]
    return [
        *_rows("Table 1", "FLC: contour RMS", TABLE_1["FLC"], found[FLC].contour),
        *_rows("Table 1", "SOFLC: contour RMS", TABLE_1["SOFLC"], found[SOFLC].contour),
        *_rows("Table 3", "SOFLC without friction: contour RMS", TABLE_3_WITHOUT, easy.contour),
        Row("7", "0.377 m/min: contour RMS, PID / SOFLC", 1.4, ratio, "real machine"),
    ]


def _rows(
    figure: str, what: str, published: tuple[float | None, ...], found: list[float]
) -> list[Row]:
    return [
        Row(figure, f"{what}, cycle {k + 1} [BLU]", value, found[k])
        for k, value in enumerate(published)
        if value is not None
    ]


def scaled(name: str, terms: float, centroids: float, **controller: Any) -> Design:
    """A design with its error terms and its centroids made larger by factors."""
    record = load_design(name).model_dump(mode="json")["controller"]
    edges = [
        {
            key: value if key == "label" or value is None else terms * value
            for key, value in t.items()
        }
        for t in record["error_terms"]
    ]
    table = [[centroids * u for u in row] for row in record["rules"]["centroids"]]
    return changed(name, error_terms=edges, rules={"centroids": table}, **controller)


def _overlap(error: float, change: float) -> dict[str, Any]:
    return {"smallest_overlap": {"error": error, "error_change": change}}


#: The steps of JK95 with two least overlaps, and without or with a stable range as JK04 has it.
OVERLAPS = {
    "of a step": {"k_b": 0.2} | _overlap(0.5, 0.2),
    "5 and 1 BLU": {"k_b": 0.2} | _overlap(5.0, 1.0),
}
LIMITS = {
    "no range": {"stable_range": {"k1_max": 1e3, "k2_max": 1e3}},
    "range": {"stable_range": {"k1_max": 4.0, "k2_max": 6.79}},
}
PRINTED = "plant.parameters.gain=28.3"
#: Name -> fixed and adaptive design, change of the scenario.
VARIANTS: dict[str, tuple[Design, Design, tuple[str, ...]]] = {
    "as built in": (changed(FLC), changed(SOFLC), ()),
    "overlap 3 and 0.5 BLU": (changed(FLC), changed(SOFLC, adaptation=_overlap(3.0, 0.5)), ()),
    "overlap 5 and 1 BLU": (changed(FLC), changed(SOFLC, adaptation=_overlap(5.0, 1.0)), ()),
    "singletons fixed": (changed(FLC), changed(SOFLC, adaptation={"k_c": 0.0}), ()),
    "singletons by 0.2": (changed(FLC), changed(SOFLC, adaptation={"k_c": 0.2}), ()),
    **{
        f"K_I = {gain / 100:g} (here {gain:g})": (
            changed(FLC, integral_gain=gain),
            changed(SOFLC, integral_gain=gain),
            (),
        )
        for gain in (1.0, 2.0, 4.0, 8.0)
    },
    "K_I = 0.08 (here 8), overlap 7 and 1.5 BLU": (
        changed(FLC, integral_gain=8.0),
        changed(SOFLC, integral_gain=8.0, adaptation=_overlap(7.0, 1.5)),
        (),
    ),
    "K = 28.3, K_I = 0.08 (here 8)": (
        changed(FLC, integral_gain=8.0),
        changed(SOFLC, integral_gain=8.0),
        (PRINTED,),
    ),
    "K = 28.3, error terms x 0.63, centroids x 3": (
        scaled(FLC, 0.63, 3.0),
        scaled(SOFLC, 0.63, 3.0),
        (PRINTED,),
    ),
    "K = 28.3, error terms x 0.47, centroids x 2": (
        scaled(FLC, 0.47, 2.0),
        scaled(SOFLC, 0.47, 2.0),
        (PRINTED,),
    ),
    **{
        f"blame of {paper}, overlap {overlap}, {limit}": (
            changed(FLC),
            changed(name, adaptation=steps | limits),
            (),
        )
        for paper, name in (("JK95", SOFLC), ("JK04", AFLC))
        for overlap, steps in OVERLAPS.items()
        for limit, limits in LIMITS.items()
    },
}  # fmt: skip


def variants(names: tuple[str, ...] = tuple(VARIANTS)) -> tuple[str, dict[str, Cycles]]:
    """What the paper leaves open does to the circle of figs. 3 and 4: table, adaptive figures."""
    lines = [["the paper", "6.36 to 6.08", "1.87", "3.31", "1.82", "1.39", "1.24", "1.23"]]
    found = {}
    for name in names:
        fixed, adaptive, changes = VARIANTS[name]
        flc = cycles(run(fixed, HERE / "circle.toml", *changes))
        own = found[name] = cycles(run(adaptive, HERE / "circle.toml", *changes))
        axial = (f"{own.axial[k]:.2f}" for k in (0, 2))
        off = (f"{value:.2f}" for value in own.contour)
        lines.append([name, f"{flc.axial[-1]:.2f}", f"{flc.contour[-1]:.2f}", *axial, *off])
    header = ["circle of figs. 3 and 4", "FLC axial", "FLC contour", "SOFLC axial 1", "3",
              "SOFLC contour 1", "2", "3"]  # fmt: skip
    return markdown(header, lines), found


@click.command()
@click.option("--out", type=click.Path(path_type=Path), default=Path("runs/jee-koren-1995"))
def main(out: Path) -> None:
    """Write the figure and tables into a folder and print the tables."""
    out.mkdir(parents=True, exist_ok=True)
    rows = [*fast(out / "fig-03-04.svg"), *slow()]
    click.echo(write(out, rows, {"variants": variants()[0]}), nl=False)


if __name__ == "__main__":
    main()
