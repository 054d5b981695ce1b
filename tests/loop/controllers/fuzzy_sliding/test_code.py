"""C that adapts as the runtime does, Structured Text with the rules to start from, the exports."""

import numpy as np
import pytest
from sliding import EVERY, sliding
from structured_text import FunctionBlock

from hfc_design.core.records import UserError
from hfc_design.formats import FORMATS, code
from hfc_design.runtime import Controller
from hfc_design.runtime.explain import explanation
from plants import FEED_DRIVE


def wandering(count=3000):
    """Errors and rates all over the table and beyond it, with rests, jumps and whole numbers."""
    random = np.random.default_rng(0)
    k = np.arange(count)
    error = 50.0 * np.sin(k / 40.0) + random.normal(0.0, 3.0, count)
    rate = 1500.0 * np.cos(k / 40.0) + random.normal(0.0, 200.0, count)
    error[1000:1100], rate[1000:1100] = 0.0, 0.0
    error[2000:] = np.round(error[2000:])
    error[::50] *= 3.0
    corners = [[20.0 * i, 2000.0 / 3.0 * j] for i in range(-4, 5) for j in range(-4, 5)]
    far = [[x, y] for x in (1.7e308, -1.7e308, 0.0, 1e-300) for y in (1e300, -1e300, 0.0)]
    return np.array([*np.stack([error, rate], axis=1), *corners, *far, [1.0, 1.0]])


def of_the_runtime(design, samples):
    controller = Controller(design)
    rows = (dict(zip(("error", "error_rate"), row, strict=True)) for row in samples.tolist())
    return np.array([controller.step(row) for row in rows])


@pytest.mark.parametrize("name", EVERY)
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
    with pytest.raises(UserError, match=r"no controller\.m for kind fuzzy-sliding; fll holds"):
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
