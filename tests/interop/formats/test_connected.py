"""Connected code on what a simulated machine's sensors tell: the simulator's own commands.

Measured: at most 7e-13 of the largest command in C, where the observer of a C-axis sums readings of
1e-5 rad over 10,000 samples.
"""

import subprocess

import numpy as np
import pytest
from c_program import WARNINGS, built, commands
from connections import CASES, MACHINES, connected, simulated
from node import in_node
from structured_text import FunctionBlock

from hfc_design.formats import FORMATS, code
from hfc_design.formats.deployment.vectors import vectors
from hfc_design.formats.scripts import function
from hfc_design.formats.st import text_of
from hfc_design.formats.writing import write


@pytest.mark.parametrize("name", CASES)
def test_commands_are_those_of_the_simulation(name, program, tmp_path):
    program("gcc")
    design, rows, (axis,) = simulated(name)
    found = commands(built("gcc", design, tmp_path, "-ffp-contract=off"), rows)
    fixed = axis.drive.coefficients(axis.parameters)
    accepted = [float(axis.drive.accepted(fixed, command)) for command in found.tolist()]
    size = np.abs(axis.motion.command).max()
    np.testing.assert_allclose(accepted, axis.motion.command, rtol=0, atol=2e-12 * size)


@pytest.mark.parametrize("name", MACHINES)
def test_a_whole_machine_commands_what_it_does_in_the_simulation(name, program, tmp_path):
    """As above; that C does the same is seen by its own vectors."""
    design, rows, axes = simulated(name)
    found = in_node(program("node"), design, rows, tmp_path).reshape(-1, len(axes)).T
    for axis, own in zip(axes, found.tolist(), strict=True):
        fixed = axis.drive.coefficients(axis.parameters)
        accepted = [float(axis.drive.accepted(fixed, command)) for command in own]
        size = np.abs(axis.motion.command).max()
        np.testing.assert_allclose(accepted, axis.motion.command, rtol=0, atol=2e-12 * size)
    write(tmp_path / "c", FORMATS["c"].content(design))
    flags = f"CFLAGS=-std=c99 -O2 -ffp-contract=off {WARNINGS}"
    checked = subprocess.check_output(["make", "-C", tmp_path / "c", "check", flags], text=True)
    assert "largest difference 0 " in checked


@pytest.mark.parametrize("name", CASES | MACHINES)
def test_every_language_does_what_c_does(name, program, octave, tmp_path):
    """On the vectors, in which it is switched, takes over and leaves its reference."""
    design = connected(name)
    told = vectors(design)
    end = told.resets.index(True, 1)
    rows, wanted = np.array(told.inputs[:end]), np.array(told.commands[:end])
    assert (wanted == 0.0).any()
    exact = 1e-12 * np.abs(wanted).max()
    found = in_node(program("node"), design, rows, tmp_path).reshape(wanted.shape)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=exact)
    known, block = code.flat(design), FunctionBlock(text_of(design))
    found = []
    for row in rows.tolist():
        given = dict(zip(known.inputs, row, strict=True))
        given |= {key: given[key] > 0.5 for key in known.truths}
        block.step(**given)
        found.append([block.values[name] for name in known.outputs])
    np.testing.assert_allclose(found, wanted, rtol=0, atol=exact)
    (tmp_path / "controller.m").write_text(function(design, "controller"))
    np.savetxt(tmp_path / "signals", rows[:200], fmt="%.17g")
    files = tmp_path, tmp_path / "signals", ",".join(known.inputs), tmp_path / "commands"
    found = octave("evaluate_controller.m", *files).reshape(-1, wanted.shape[1])
    np.testing.assert_allclose(found, wanted[:200], rtol=0, atol=exact)
