"""The laboratory in Chromium: what it draws is what the simulator computes, whatever is moved."""

import numpy as np
import pytest
from devtools import chromium

from hfc_design import api
from hfc_design.files.loop_setup import own_scenario
from hfc_design.report.laboratory import laboratory_page

#: Design, its scenario if it is not its own, and what is moved: key of a slider -> factor.
CASES = {
    "pd-only": (
        "c-axis-practical",
        {"controller.pd.kd": 0.6, "spindle_inertia": 1.3, "sensors.encoder_resolution": 10.0},
    ),
    "lin-lee-1999-table-1": (None, {"controller.inputs.0.scale": 0.5, "stiffness": 2.0}),
    "huang-pid": (None, {"controller.pid.k_p": 1.5, "backlash": 1.2}),
    "jee-koren-2004-aflc": (None, {"time_constant": 1.5}),
    "lin-gai-2009-fuzzy-sliding": (None, {"controller.axes.x.sliding.gain": 2.0, "inertia": 1.2}),
}


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("chromium")) as one:
        yield one


@pytest.mark.parametrize("name", CASES)
def test_a_moved_slider_gives_what_the_simulator_computes(browser, name, tmp_path):
    design, (own, moved) = api.load_design(name), CASES[name]
    scenario = api.load_scenario(own) if own else own_scenario(design, name)
    page = tmp_path / "laboratory.html"
    page.write_bytes(laboratory_page(design, scenario).html)
    browser.open(page)
    browser.until("typeof now !== 'undefined' && now !== null")
    of, on = {}, {}
    axes = scenario.plant.machine.axes
    inside = f"plant.axes.{axes[0]}." if axes[1:] else "plant.parameters."
    for key, factor in moved.items():
        place = browser.value(f"data.sliders.findIndex((one) => one.key === '{key}')")
        value = factor * browser.value(f"data.sliders[{place}].value")
        browser.value(f"rows[{place}]({value})")
        browser.until("!busy && !waiting")
        if key.startswith("controller"):
            of[key] = value
        else:
            on[key if "." in key else inside + key] = value
    changed = api.load_scenario(scenario, on)
    evaluation = api.evaluate(api.load_design(design, of), changed)
    evaluation = next(iter(evaluation.motions.values()), evaluation)
    shown, stride = browser.value("now.shown"), browser.value("now.stride")
    for k, axis in enumerate(evaluation.axes):
        for part, whole in {"error": axis.motion.error, "command": axis.motion.command}.items():
            found = browser.value(
                f"Array.from(now.{part}.subarray({k * shown}, {(k + 1) * shown}))"
            )
            wanted = np.asarray(whole)
            if part == "command":  # the page shows that of the sample before
                wanted = np.append(0.0, wanted[:-1])
            size = np.abs(wanted).max()
            np.testing.assert_allclose(found, wanted[::stride], rtol=0.0, atol=1e-9 * size)
    text = browser.value("JSON.stringify(changedDesign())")
    (tmp_path / "design.json").write_text(text)
    downloaded = api.load_design(tmp_path / "design.json")
    assert downloaded.controller == api.load_design(design, of).controller
    # The address holds what was moved: the page opens again with it.
    browser.value("kept()")
    browser.send("Page.reload")
    browser.until("typeof now !== 'undefined' && now !== null")
    assert browser.value("JSON.stringify(changedDesign())") == text
    assert not browser.complaints
