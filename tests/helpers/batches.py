"""Batches as a user calls them, and the files that they leave."""

from click.testing import CliRunner

from hfc_design.cli import main

TINY = """
[set]
search.population = 12
search.generations = 3
simulation.duration_s = 0.1
"""
GRID = f"""{TINY}
[grid]
scenario = ["c-axis-ramp", "c-axis-ramp-cutting"]
run.seed = [0, 1]
"""
#: Of gains, whose programs are compiled soonest.
QUICK = GRID.replace("[grid]", 'controller.kind = "pd"\n[grid]')


def written(tmp_path, text, name="mine.toml"):
    path = tmp_path / name
    path.write_text(text)
    return path


def batch(*arguments):
    return CliRunner().invoke(main, ["batch", *map(str, arguments)])


def files(out):
    """Every file of every run folder, by its path."""
    cells = [path for path in out.iterdir() if path.is_dir() and path.name[0] != "."]
    return {
        str(file.relative_to(out)): file.read_bytes()
        for cell in cells
        for file in sorted(cell.iterdir())
    }


def left_behind(path, text):
    """The files of a batch when nothing happens to it."""
    found = batch(written(path, text), "--out", path / "out")
    assert found.exit_code == 0, found.output
    return files(path / "out")
