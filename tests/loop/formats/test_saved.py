"""What C code has learnt: saved, taken up by another process, brought back to a design."""

import subprocess

import made_up
import numpy as np
import pytest
from c_program import KEEPING, built
from c_program import commands as of_the_program
from sliding import EVERY

from hfc_design.files.pairing import load_design
from hfc_design.formats import code, saving

ADAPTING = {"k_c": 1e-2, "largest_move": 0.5, "error_scale": 3.0}
DESIGNS = {
    "aflc": load_design("jee-koren-2004-aflc"),
    "aflc with an integral": made_up.limited(made_up.fuzzy("aflc", 1), 40.0),
    "soflc": load_design("jee-koren-1995-soflc"),
    **{
        f"fuzzy-sliding {name}": EVERY[name]
        for name in EVERY
        if "within" in name or "with " in name
    },
    "hierarchy": made_up.hierarchy(3, 5, adaptation=ADAPTING),
    "soc": load_design("huang-soc"),
    "soc whose command is slow": load_design("huang-soc", {"limits.command_rate": 40.0}),
    "network": made_up.network(2),
    "network within a limit": made_up.limited(made_up.network(3), 8.0),
    "hierarchy on a linear part": made_up.hierarchy_on_linear(9, adaptation=ADAPTING),
}
SANITIZERS = "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"


def signals(design, count=600):
    """Samples (count, signals) that make it learn, with rests and jumps."""
    random = np.random.default_rng(4)
    walk = random.normal(0.0, 1.0, (count, len(code.signals(design)))).cumsum(axis=0)
    walk[200:220] = 0.0
    return walk * {"feed-drive": 1.0, "milling-table": 0.01}.get(design.plant.name, 0.1)


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """The program of a design, compiled once."""
    known = {}

    def of(name):
        if name not in known:
            folder, main = tmp_path_factory.mktemp("c") / "c", KEEPING.replace("REST", "")
            known[name] = built("gcc", DESIGNS[name], folder, *SANITIZERS, main=main)
        return known[name]

    return of


def commands(run, samples, begins, ends, real=np.float64):
    return of_the_program(run, samples, real, (begins, ends))


@pytest.mark.parametrize("name", DESIGNS)
def test_numbers_that_cannot_be_are_refused_and_change_nothing(name, program, tmp_path):
    run, design, kept, end = program(name), DESIGNS[name], tmp_path / "kept", tmp_path / "end"
    commands(run, signals(design)[:100], "-", kept)
    good = np.fromfile(kept)
    commands(run, signals(design)[:0], "-", end)
    fresh = end.read_bytes()
    saved = saving.values(design)
    whole = [told for told in saved["members"] if told["whole"]]
    odd = [good[: saved["learnt"] - 1], np.append(good, 0.0), good[:0]]
    for place, value in [(0, np.nan), (len(good) - 1, np.inf), (3, -np.inf)] + [
        (told["first"], wrong)
        for told in whole
        for wrong in (told["whole"][0] - 1, told["whole"][1] + 1, told["whole"][0] + 0.5)
    ]:
        odd.append(good.copy())
        odd[-1][place] = value
    for numbers in odd:
        numbers.tofile(kept)
        done = subprocess.run([run, kept, end], input=b"", capture_output=True, check=False)
        assert (done.returncode, done.stderr) == (3, b"")
        assert end.read_bytes() == fresh


def test_what_does_not_learn_saves_nothing(tmp_path):
    for name in ("jee-koren-2004-flc", "lin-lee-1999-table-1", "pd-only"):
        text = code.sources(load_design(name))
        assert not any("_save(" in own for own in text.values())
