"""What C and Structured Text make of a user's own kind: the runtime's numbers."""

import numpy as np
from c_program import built, commands
from structured_text import FunctionBlock

from hfc_design import runtime
from hfc_design.formats import code


def test_c_and_structured_text_do_what_the_runtime_does(toy, tmp_path):
    errors = np.random.default_rng(1).normal(0.0, 3.0, 500)
    controller = runtime.Controller(toy)
    expected = np.array([controller.step({"error": error}) for error in errors])
    program = built("gcc", toy, tmp_path / "c")
    assert commands(program, errors[:, None]).tolist() == expected.tolist()  # bit for bit
    (tmp_path / "toy.st").write_text(code.block(toy))
    block = FunctionBlock((tmp_path / "toy.st").read_text())
    assert [block.step(error=error) for error in errors] == expected.tolist()
