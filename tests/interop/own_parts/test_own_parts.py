"""What C, Structured Text and JavaScript make of a user's own kind: the runtime's numbers."""

import numpy as np
from c_program import built, commands
from node import in_node
from structured_text import FunctionBlock

from hfc_design import runtime
from hfc_design.formats.st import text_of


def test_all_languages_do_what_the_runtime_does(toy, program, tmp_path):
    errors = np.random.default_rng(1).normal(0.0, 3.0, 500)
    controller = runtime.Controller(toy)
    expected = np.array([controller.step({"error": error}) for error in errors])
    compiled = built("gcc", toy, tmp_path / "c")
    assert commands(compiled, errors[:, None]).tolist() == expected.tolist()  # bit for bit
    block = FunctionBlock(text_of(toy))
    assert [block.step(error=error) for error in errors] == expected.tolist()
    inside = in_node(program("node"), toy, errors[:, None], tmp_path)
    assert inside.tolist() == expected.tolist()
