"""What C code has learnt: saved, taken up by another process, brought back to a design."""

import subprocess

import made_up
import numpy as np
import pytest
from c_program import KEEPING, built
from c_program import commands as of_the_program
from sliding import EVERY

from hfc_design.files.design import with_learned
from hfc_design.files.loop_setup import load_design
from hfc_design.formats import code, saving
from hfc_design.runtime import Controller

ADAPTING = {"k_c": 1e-2, "largest_move": 0.5, "error_scale": 3.0}
DESIGNS = {
    "aflc": load_design("jee-koren-2004-aflc"),
    "aflc with an integral": made_up.limited(made_up.fuzzy("aflc", 1), 40.0),
    "soflc": load_design("jee-koren-1995-soflc"),
    "hierarchy": made_up.hierarchy(3, 5, adaptation=ADAPTING),
    "soc": load_design("huang-soc"),
    "soc whose command is slow": load_design("huang-soc", {"limits.command_rate": 40.0}),
    "network": made_up.network(2),
    "network within a limit": made_up.limited(made_up.network(3), 8.0),
    "hierarchy on a linear part": made_up.hierarchy_on_linear(9, adaptation=ADAPTING),
}
SLIDING = [name for name in EVERY if "within" in name or "with " in name]
DESIGNS |= {f"fuzzy-sliding {name}": EVERY[name] for name in SLIDING}
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


def of_the_runtime(design, samples):
    controller, names = Controller(design), list(code.signals(design))
    told = [controller.step(dict(zip(names, row, strict=True))) for row in samples.tolist()]
    return controller, np.array(told)


@pytest.mark.parametrize("name", DESIGNS)
def test_half_a_motion_and_the_rest_in_another_process(name, program, tmp_path):
    """Bit for bit the uninterrupted run, and what the runtime does."""
    design, run = DESIGNS[name], program(name)
    samples, kept, end = signals(design), tmp_path / "kept", tmp_path / "end"
    whole = commands(run, samples, "-", tmp_path / "whole")
    first = commands(run, samples[:290], "-", kept)
    rest = commands(run, samples[290:], kept, end)
    np.testing.assert_array_equal(np.concatenate([first, rest]), whole)
    assert end.read_bytes() == (tmp_path / "whole").read_bytes()
    controller, expected = of_the_runtime(design, samples)
    np.testing.assert_allclose(whole, expected, rtol=1e-12, atol=1e-12)
    # Back on the PC: the record that the runtime has learnt.
    numbers = np.fromfile(end).tolist()
    found = saving.taken(design, numbers)
    assert found == saving.taken(design, numbers[: saving.saved(design).learnt])
    assert found != design.controller
    _same(found.model_dump(), controller.adapted().model_dump())
    assert with_learned(design, found, {}).name == f"{design.name}-learned"


def _same(found, expected, place=""):
    if isinstance(expected, dict):
        assert found.keys() == expected.keys()
        for key, own in expected.items():
            _same(found[key], own, f"{place}.{key}")
    elif isinstance(expected, list | tuple):
        for k, (one, other) in enumerate(zip(found, expected, strict=True)):
            _same(one, other, f"{place}.{k}")
    elif isinstance(expected, float):
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)
    else:
        assert found == expected


@pytest.mark.parametrize("name", ["aflc", "hierarchy on a linear part"])
def test_rest_forgets_all_but_what_was_learnt(name, tmp_path):
    """Then it does what the design does that the runtime has learnt."""
    design, kept = DESIGNS[name], tmp_path / "kept"
    run = built("gcc", design, tmp_path / "c", main=KEEPING.replace("REST", "{name}_rest(&state);"))
    samples = signals(design)
    commands(run, samples[:290], "-", kept)
    controller, _ = of_the_runtime(design, samples[:290])
    learned = with_learned(design, controller.adapted(), {})
    found = commands(run, samples[290:], kept, "-")
    _, expected = of_the_runtime(learned, samples[290:])
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_single_precision_comes_back_too(tmp_path):
    design = DESIGNS["aflc"]
    main = KEEPING.replace("REST", "")
    run = built("gcc", design, tmp_path / "c", "-DHFC_FLOAT", main=main)
    commands(run, signals(design)[:60], "-", tmp_path / "kept", np.float32)
    numbers = np.fromfile(tmp_path / "kept", np.float32).tolist()
    learned = with_learned(design, saving.taken(design, numbers), {})
    controller, _ = of_the_runtime(design, signals(design)[:60])
    found = np.array(learned.controller.rules.centroids)
    np.testing.assert_allclose(found, controller.adapted().rules.centroids, atol=1e-5)


@pytest.mark.parametrize("name", DESIGNS)
def test_numbers_that_cannot_be_are_refused_and_change_nothing(name, program, tmp_path):
    run, design, kept, end = program(name), DESIGNS[name], tmp_path / "kept", tmp_path / "end"
    commands(run, signals(design)[:100], "-", kept)
    good = np.fromfile(kept)
    commands(run, signals(design)[:0], "-", end)
    fresh = end.read_bytes()
    saved = saving.saved(design)
    whole = [told for told in saved.members if told.whole]
    odd = [good[: saved.learnt - 1], np.append(good, 0.0), good[:0]]
    for place, value in [(0, np.nan), (len(good) - 1, np.inf), (3, -np.inf)] + [
        (told.first, wrong) for told in whole for wrong in (-1.0, 2.0, 0.5)
    ]:
        odd.append(good.copy())
        odd[-1][place] = value
    for numbers in odd:
        numbers.tofile(kept)
        done = subprocess.run([run, kept, end], input=b"", capture_output=True, check=False)
        assert (done.returncode, done.stderr) == (3, b"")
        assert end.read_bytes() == fresh
