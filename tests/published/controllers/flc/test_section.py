"""The report of a run that designs a feed drive's fuzzy controllers."""

import feed_oracle
import numpy as np
import pytest
from feed_oracle import verdict_jk04
from fuzzy_report import reported
from jk04 import CHANGE_TERMS, ERROR_TERMS, rule_singletons
from report_pages import write

from hfc_design.controllers.aflc.section import at_the_end
from hfc_design.controllers.kind import ReportContext
from hfc_design.files.machine import SensorSettings
from hfc_design.report.parts import sections


@pytest.fixture(scope="module", params=["flc", "aflc"])
def report(request, tmp_path_factory):
    return reported(request.param, tmp_path_factory.mktemp(request.param) / "run")


def test_same_run_gives_the_same_bytes(report):
    arguments, page = report
    write(*arguments)
    assert (arguments[2] / "report.html").read_text() == page


def test_adapted_table_is_that_of_a_plain_transcription(report):
    scenario, result, _, _ = report[0]
    design, own = result.design, result.evaluation
    title = "Result of the adaptation"
    titles = [section.title for section in sections(design, own, scenario)]
    if design.controller.kind == "flc":
        assert title not in titles
        return
    assert title in titles
    signals = {axis.name: axis.sensed() for axis in own.axes}
    found = at_the_end(
        design.controller, ReportContext(own.machine, scenario.plant.values(), signals)
    )
    assert list(found) == ["X", "Y"]
    for axis, record in zip(own.axes, found.values(), strict=True):
        expected = feed_oracle.Adaptive(
            ERROR_TERMS,
            CHANGE_TERMS,
            rule_singletons("I"),
            (0.5, 0.125, 1.0),
            verdict_jk04,
            (5.25, 3.5),
        )
        for error in axis.reference - np.round(axis.motion.state.position):
            expected.step(error)
        assert expected.c != [list(row) for row in rule_singletons("I")]
        np.testing.assert_allclose(record.rules.centroids, expected.c, atol=1e-9)
        np.testing.assert_allclose(record.table().error_terms, expected.a, atol=1e-9)
        np.testing.assert_allclose(record.table().change_terms, expected.b, atol=1e-9)
    noisy = scenario.model_copy(update={"sensors": SensorSettings(noise=0.3)})
    assert title not in [section.title for section in sections(design, own, noisy)]
    lost = own._replace(diverged=True)
    assert title not in [section.title for section in sections(design, lost, scenario)]
