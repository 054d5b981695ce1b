"""The genome: it begins with the start, keeps to its ranges, and is the design that it writes."""

import numpy as np
import pytest
from sliding import DYNAMICS, EVERY, PID, TABLE_2, of_the_runtime, sliding, wandering
from structured_text import FunctionBlock
from wording import refused

from hfc_design.controllers.fuzzy_sliding.pictures import sections
from hfc_design.controllers.genome import taken
from hfc_design.controllers.kind import ReportContext
from hfc_design.controllers.kinds import KINDS
from hfc_design.files.loop_setup import population_of_one
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import FORMATS
from hfc_design.formats.st import text_of
from hfc_design.plotting.files import image
from hfc_design.runs import individuals
from plants import FEED_DRIVE, side_by_side

CIRCLE = {"controller": {"kind": "fuzzy-sliding"}, "limits.command": 120.0}


def genome(**settings):
    scenario = load_scenario(
        "feed-drive-circle", CIRCLE | {"controller": settings | CIRCLE["controller"]}
    )
    return individuals.genome_of(scenario)


def bred(own, count=50):
    rng = np.random.default_rng(5)
    found = own.fresh(np.zeros(count, int), rng)
    for _ in range(4):
        mixed = own.blended(found, taken(found, rng.permutation(count)), rng.uniform(0, 1, count))
        found = own.mutated(mixed, np.full(count, 0.5), rng)
    return found


def record_of(own, individual):
    data = {"sample_time_s": own.target.sample_time, **own.record(individual)}
    return KINDS.get("fuzzy-sliding").record.model_validate(data)


def leaves(gains):
    return [np.asarray(x, float).ravel() for x in gains if x is not None]


STARTS = {
    "of the machine": {},
    "with every consequent": {"consequents": True},
    "and both directions apart": {"consequents": True, "symmetric": False},
    "of a design": {
        "start": sliding(
            pid={"k_p": 1.0, "k_d": 0.01},
            adaptation={"rate": 2.0, "largest_move": 40.0, "error_dynamics": DYNAMICS},
        ).controller.model_dump()
    },
}


@pytest.mark.parametrize("name", STARTS)
def test_an_individual_is_the_design_that_it_writes(name):
    own = genome(**STARTS[name])
    population = bred(own)
    many = own.gains(population)
    for k in (0, 7):
        record = record_of(own, taken(population, slice(k, k + 1)))
        alone = population_of_one(record.law_gains())
        for one, each in zip(leaves(alone), (x for x in many if x is not None), strict=True):
            np.testing.assert_allclose(np.asarray(each, float)[..., k].ravel(), one, rtol=1e-12)

    found = record_of(own, own.empty())
    for one, other in zip(leaves(found.law_gains()), leaves(own.start.law_gains()), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12)


def test_a_start_of_the_machine_is_table_2_at_the_printed_gain():
    """Top speed 40 x 127 BLU/s; 120 units at the error of which 33.33 1/s ask for that speed."""
    start = genome().start
    np.testing.assert_allclose(start.consequents, 120.0 * TABLE_2)
    assert start.largest_error == pytest.approx(40.0 * 127.0 / 33.33)


def test_what_is_symmetric_stays_so():
    own = genome(consequents=True)
    table = own.consequents(bred(own))
    np.testing.assert_allclose(table, -table[::-1, ::-1], atol=1e-9)
    own = genome(consequents=True, symmetric=False)
    table = own.consequents(bred(own))
    assert np.abs(table + table[::-1, ::-1]).max() > 1.0


def test_ranges_are_kept_to():
    own = genome(ranges={"slope": [5.0, 6.0], "gain": [0.0, 0.0]})
    found = own.gains(bred(own))
    assert 5.0 <= found.slope.min() < found.slope.max() <= 6.0
    assert (found.switching == 0.0).all()


@pytest.mark.parametrize(
    "changes",
    [
        {"controller": {"ranges": {"phi": [0.0, 1.0]}}},
        {"controller": {"start": "jee-koren-2004-flc"}},
        {"controller": {"start": "nowhere.json"}},
        {"simulation.sample_time_s": 0.005, "controller": STARTS["of a design"]},
    ],
)
def test_what_cannot_be_searched_is_told(changes):
    own = changes | {"controller": changes["controller"] | CIRCLE["controller"]}
    with refused() as found:
        load_scenario("feed-drive-circle", own)
    assert found.where == "feed-drive-circle"


def measured(steps=300):
    k = np.arange(steps)
    return {"error": 20.0 * np.sin(k / 30.0), "error_rate": 300.0 * np.cos(k / 30.0)}


def test_every_axis_has_its_pictures():
    machine = side_by_side(x=FEED_DRIVE, y=FEED_DRIVE)
    shown = ReportContext(
        machine, (FEED_DRIVE.parameters(),) * 2, {"x": measured(), "y": measured(2)}
    )
    whole, x, y = sections(sliding(pid=PID).controller, shown)
    assert [part.title for part in (x, y)] == ["Learning of X", "Learning of Y"]
    rows = {name: (value, unit) for name, value, unit in whole.listing.rows}
    assert rows["slope of the surface, λ"] == ("20", "1/s")
    assert rows["judgement of the error, P₂"] == ("20", "1/s")
    assert rows["beside the rules, k_i"] == ("8", "unit/(BLU s)")
    for part in (whole, x, y):
        for drawing in part.drawings:
            assert image(drawing.figure, "svg").startswith(b"<?xml")


@pytest.mark.parametrize("name", ["beside a pid within a limit", "with what it learnt"])
def test_structured_text_learns_as_the_runtime_does(name):
    design = EVERY[name]
    block = FunctionBlock(text_of(design))
    samples = wandering(300)[:380]
    rows = (dict(zip(("error", "error_rate"), row, strict=True)) for row in samples.tolist())
    found = [block.step(**row) for row in rows]
    expected = of_the_runtime(design, samples)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("target", ["csv", "fis", "fll", "fcl", "fml", "mat", "linuxcnc"])
def test_every_format_has_it(target, tmp_path):
    FORMATS[target].write(sliding(100.0), tmp_path / "out")
    assert (tmp_path / "out").exists()
