"""A fault that is put into one law shows in every language: all are printed from it."""

import numpy as np
import pytest
from c_program import built, commands
from node import in_node
from random_designs import design_of, of_the_runtime, samples_of
from structured_text import FunctionBlock

from hfc_design.controllers.kinds import KINDS
from hfc_design.formats import code, laws
from hfc_design.formats.scripts import function
from hfc_design.formats.st import text_of


def faulty(kind):
    """A law of the kind that is off by a millionth of its command."""
    good = kind.law

    def law(record, limit):
        own = good(record, limit)

        def sample(xp, law, gains, memory, signals):
            command, after, parts = own.sample(xp, law, gains, memory, signals)
            return command * 1.000001, after, parts

        return own._replace(sample=sample)

    return law


@pytest.mark.parametrize("name", ["pid", "aflc", "pd+hierarchical-fuzzy", "neural"])
def test_it_shows_in_every_language(name, program, octave, tmp_path, monkeypatch):
    design = design_of(name, 2)
    samples = samples_of(design, 2)[:60]
    samples = samples[np.isfinite(samples).all(axis=1) & (np.abs(samples) < 1e6).all(axis=1)]
    good = of_the_runtime(design, samples)
    monkeypatch.setattr(KINDS.get(name), "law", faulty(KINDS.get(name)))
    monkeypatch.setattr(laws, "_KEPT", {})
    size = np.abs(good).max()
    found = {"runtime": of_the_runtime(design, samples)}
    found["C"] = commands(built("gcc", design, tmp_path / "c"), samples)
    (tmp_path / "js").mkdir()
    found["JavaScript"] = in_node(program("node"), design, samples, tmp_path / "js")
    names, block = list(code.signals(design)), FunctionBlock(text_of(design))
    rows = (dict(zip(names, row, strict=True)) for row in samples.tolist())
    found["Structured Text"] = np.array([block.step(**row) for row in rows])
    (tmp_path / "controller.m").write_text(function(design, "controller"))
    np.savetxt(tmp_path / "signals", samples, fmt="%.17g")
    files = tmp_path, tmp_path / "signals", ",".join(names), tmp_path / "commands"
    found["MATLAB"] = octave("evaluate_controller.m", *files)
    for language, own in found.items():
        assert np.abs(own - good).max() > 1e-7 * size, language
        np.testing.assert_allclose(own, found["runtime"], rtol=0, atol=1e-10 * size)
