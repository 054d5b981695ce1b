"""C that adapts as the runtime does, Structured Text with the rules to start from, the exports."""

import numpy as np
import pytest
from sliding import EVERY, of_the_runtime, sliding, wandering
from structured_text import FunctionBlock
from wording import refused

from hfc_design.formats import FORMATS, code
from hfc_design.runtime.explain import explanation
from plants import FEED_DRIVE


@pytest.mark.parametrize("name", ["beside a pid within a limit", "with what it learnt"])
def test_structured_text_holds_what_it_starts_from(name, tmp_path):
    design = EVERY[name]
    held = design.model_copy(update={"controller": design.controller.held()})
    (tmp_path / "design.st").write_text(code.block(design))
    text = (tmp_path / "design.st").read_text()
    assert "the adaptation is not here" in text
    block = FunctionBlock(text)
    samples = wandering(300)[:380]
    rows = (dict(zip(("error", "error_rate"), row, strict=True)) for row in samples.tolist())
    found = [block.step(**row) for row in rows]
    expected = of_the_runtime(held, samples)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("target", ["csv", "fll", "fcl", "fml", "mat", "linuxcnc"])
def test_every_format_has_it(target, tmp_path):
    FORMATS[target].write(sliding(100.0), tmp_path / "out")
    assert (tmp_path / "out").exists()


def test_what_matlab_would_not_compute_is_refused(tmp_path):
    with refused():
        FORMATS["fis"].write(sliding(), tmp_path / "out")


def test_what_a_command_is_made_of():
    told = explanation(
        sliding(100.0), FEED_DRIVE, FEED_DRIVE.parameters(), ["error=30,error_rate=1000"]
    )
    assert told["parts"] == pytest.approx({"fuzzy": 90.0, "switching": 10.0})
    (unit,) = told["units"]
    assert [rule["share"] for rule in unit["rules"]] == pytest.approx([0.25] * 4)
    assert {(rule["row"], rule["column"]) for rule in unit["rules"]} == {
        (a, b) for a in ("SP", "MP") for b in ("SP", "MP")
    }
    assert told["adaptation_held"]
