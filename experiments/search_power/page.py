"""The table and the pictures of README.md, of the results that stand beside it.

python -m experiments.search_power.page
"""

from pathlib import Path

import click

from experiments.search_power.figures import ALPHA, HEADER, beaten, picture, read, table
from experiments.shared import markdown
from hfc_design.cli.usage import Plain
from hfc_design.plotting.files import save

HERE = Path(__file__).parent


@click.command(cls=Plain)
@click.option("--results", default=HERE / "results", type=click.Path(path_type=Path))
@click.option("--out", default=HERE, type=click.Path(path_type=Path), help="Of the pictures.")
def main(results: Path, out: Path) -> None:
    """Draw a picture of each task and print the table."""
    found = read(results)
    for task, own in found.items():
        save(picture(own), out / f"{task}.svg")
    click.echo(markdown(HEADER, table(found)))
    tests = beaten(found)
    ahead = [one for one in tests if one.a12 > 0.5 and one.holm < ALPHA]
    click.echo(f"The default is ahead in {len(ahead)} of {len(tests)} comparisons, p < {ALPHA}.")
    for one in tests:
        if one not in ahead:
            click.echo(f"Not ahead: {one.task}, {one.peer}: A12 {one.a12:.2f}, p {one.holm:.2g}")


if __name__ == "__main__":
    main()
