"""Figures and tables of the page of Jee & Koren 2004 (JK04); see README.md beside this file.

First hfc batch experiments/jee_koren_2004/FILE for batch.toml, two-plants.toml, friction.toml and
rule-bases.toml, then python -m experiments.jee_koren_2004.page.
"""

from pathlib import Path

import click

from experiments.jee_koren_2004 import pictures
from experiments.jee_koren_2004.calculated import computing, rule_bases, stability
from experiments.jee_koren_2004.tables import friction_sets, heights, readings, variants
from experiments.shared import HEAD, Batch, chaotic, markdown
from hfc_design.cli.usage import Plain
from hfc_design.plotting.files import save

PARTS = {
    "10": pictures.circle,
    "11": pictures.line,
    "12": pictures.friction,
    "13-16b": pictures.steep_line,
    "15": pictures.slot,
    "16a": pictures.machine_circle,
    "18": pictures.steps,
}


@click.command(cls=Plain)
@click.option("--runs", default="runs/jee-koren-2004", type=click.Path(path_type=Path))
def main(runs: Path) -> None:
    """Draw the figures into the folder of the batch and print the tables."""
    one = Batch(runs)
    two, frictions, bases = (
        Batch(runs.with_name(f"{runs.name}-{name}"))
        for name in ("two-plants", "friction", "rule-bases")
    )
    for name, draw in PARTS.items():
        save(draw(one), runs / f"fig-{name}.svg")
    save(pictures.derivatives(pictures.base_files()), runs / "fig-17.svg")
    calculated = [*stability(runs / "fig-04.svg"), *rule_bases(pictures.base_files()), *computing()]
    parts = [
        readings(one, two),
        markdown(HEAD, [*one.published(), *calculated]),
        variants(one),
        chaotic(one),
        markdown(HEAD, two.published()),
        variants(two),
        chaotic(two),
        friction_sets(frictions),
        heights(bases),
    ]
    click.echo("\n".join(parts), nl=False)


if __name__ == "__main__":
    main()
