"""Controllers of a machine in Structured Text, JavaScript and Octave: what the runtime commands."""

from math import nan

import numpy as np
import pytest
from node import in_node
from structured_text import FunctionBlock
from whole_machines import DESIGNS, happenings, in_c, of_the_runtime

from hfc_design.formats.code import flat
from hfc_design.formats.scripts import function
from hfc_design.formats.st import text_of

COUNT = 150


def rows_of(design, samples):
    return in_c(design, samples)[:, : len(flat(design).inputs)]


def in_octave(design, rows, folder, octave):
    (folder / "controller.m").write_text(function(design, "controller"))
    np.savetxt(folder / "signals", rows, fmt="%.17g")
    files = folder, folder / "signals", ",".join(flat(design).inputs), folder / "commands"
    return octave("evaluate_controller.m", *files)


def in_st(design, rows):
    known, block, found = flat(design), FunctionBlock(text_of(design)), []
    for row in rows.tolist():
        block.step(**dict(zip(known.inputs, row, strict=True)))
        values = [nan if block.values["fault"] else block.values[name] for name in known.outputs]
        found.append(values)
    return np.array(found)


@pytest.mark.parametrize("name", DESIGNS)
def test_every_language_commands_what_the_runtime_does(name, program, octave, tmp_path):
    design = DESIGNS[name]
    samples = happenings(design)[:COUNT]
    told, path = samples[40]
    samples[40] = ({**told, "y": {**told["y"], "error": nan}}, path)
    rows, (_, wanted) = rows_of(design, samples), of_the_runtime(design, samples)
    assert np.isnan(wanted).sum() == 2
    size = np.nanmax(np.abs(wanted))
    node = in_node(program("node"), design, rows, tmp_path).reshape(-1, 2)
    np.testing.assert_allclose(node, wanted, rtol=0, atol=1e-13 * size)
    np.testing.assert_allclose(in_st(design, rows), wanted, rtol=0, atol=1e-13 * size)
    found = in_octave(design, rows, tmp_path, octave)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13 * size)
