"""The experiments of Jee & Koren 2004: figures that must hold, and that their page shows them."""

import pytest
from experiment_pages import EXPERIMENTS, page_of, ran, simulated, stands_in, table
from jk04 import rule_labels, rule_singletons

from experiments.jee_koren_2004 import page as jk04
from hfc_design.files.pairing import load_design


@pytest.fixture(scope="module")
def batch_04(tmp_path_factory):
    return ran(tmp_path_factory.mktemp("jk04"), "jee_koren_2004/batch.toml")


@pytest.mark.slow
def test_published_figures_of_2004(batch_04):
    stands_in(jk04, batch_04.published())
    values = simulated(batch_04)
    assert values["FLC: axial RMS, cycle 1 [BLU]"] == pytest.approx(16.2, abs=0.3)
    assert values["FLC: axial RMS, cycle 3 [BLU]"] == pytest.approx(16.2, abs=0.3)
    assert values["AFLC: axial RMS, cycle 3 [BLU]"] < 6.5  # 5.6 in the paper
    assert values["contour RMS, FLC / AFLC, cycle 3"] > 2.5  # 4 in the paper
    assert values["PID: contour RMS with friction [BLU]"] == pytest.approx(3.4, rel=0.1)
    assert values["PID: largest contour error [BLU]"] == pytest.approx(15.6, rel=0.1)


def test_fig_4(tmp_path):
    rows = jk04.stability(tmp_path / "a.svg")
    stands_in(jk04, rows)
    assert [float(row[4]) for row in rows[:2]] == [1.0, 1.0]


def test_rule_bases_2_and_3_are_those_of_the_paper():
    for number, name in ((2, "II"), (3, "III")):
        own = load_design(str(EXPERIMENTS / f"jee_koren_2004/base-{number}.json")).controller
        flc = load_design("jee-koren-2004-flc").controller
        assert own.rules.labels == rule_labels(name)
        assert own.rules.centroids == rule_singletons(name)
        assert own.error_terms == flc.error_terms
        assert own.error_change_terms == flc.error_change_terms


@pytest.mark.slow
def test_fig_18_rule_base_1_is_best(batch_04):
    one, two, three = (
        batch_04.values(f"step, rule base {base}", "iae_BLU_s")[0] for base in ("I", "II", "III")
    )
    assert one < two <= three


@pytest.mark.slow
def test_the_overlap_is_what_makes_the_contour_better(batch_04):
    narrow, wide = (
        batch_04.values(label, jk04.CONTOUR[-1])[0]
        for label in (
            "overlap of one step, 0.5 and 0.125 BLU",
            "overlap 7 and 1.5 BLU: to the neighbours' centres",
        )
    )
    assert wide < 0.5 * narrow


@pytest.mark.slow
def test_every_variant_stands_in_its_page(batch_04):
    first = [line[0] for line in table(page_of(jk04))]
    printed = [line[0] for line in table(jk04.variants(batch_04))]
    assert len(printed) > 20
    assert [name for name in printed if name not in first] == []


@pytest.mark.slow
def test_no_single_friction_gives_all(tmp_path):
    def wanted(cell):
        own = cell.settings
        machine = [own.get(f"plant.parameters.{k}") for k in ("gain", "coulomb", "stiction_rise")]
        return machine in ([40.0, 15.0, 0.0], [100.0, 9.0, 15.0]) or (
            machine[1] is None and machine[0] in (40.0, 100.0)
        )

    text = jk04.friction_sets(ran(tmp_path, "jee_koren_2004/friction.toml", wanted))
    (_, _, paper, *sets) = table(text.replace("|  |", "| - |"))
    assert paper[3:6] == ["16.2", "3.4", "15.6"]
    assert sets[0][3] == "cannot follow"
    assert [float(x) for x in sets[0][4:6]] == pytest.approx([3.4, 15.6], rel=0.1)
    assert [float(x) for x in sets[1][3:6]] == pytest.approx([16.2, 3.4, 15.6], rel=0.1)
    assert float(sets[1][-1]) > 2.0  # of the AFLC, 1.5 in the paper
    in_page = [line[:6] for line in table(page_of(jk04))]
    assert all(line[:6] in in_page for line in sets)


def test_rule_base_1_is_best_at_other_heights(tmp_path):
    file = "jee_koren_2004/rule-bases.toml"
    batch = ran(tmp_path, file, lambda cell: cell.settings["reference.height"] in (20.0, 50.0))
    lines = table(jk04.heights(batch))[2:]
    assert len(lines) == 8
    for line in lines:
        assert float(line[3]) < min(float(line[4]), float(line[5]))
        assert line in table(page_of(jk04))


def test_time_of_a_sample_stands_in_the_page():
    stands_in(jk04, jk04.computing())


@pytest.mark.slow
def test_the_figures_of_2004_are_drawn_from_the_runs(batch_04):
    for draw in (jk04.circle, jk04.line, jk04.friction, jk04.slot, jk04.steps):
        assert draw(batch_04).axes
