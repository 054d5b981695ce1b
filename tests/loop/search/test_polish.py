"""A polish against problems whose answer is known, and what it may never do."""

import numpy as np
import pytest

from hfc_design.controllers.genome import taken
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs.individuals import genome_of
from hfc_design.search.coordinates import coordinates


@pytest.mark.parametrize(
    ("scenario", "changes"),
    [
        ("c-axis-ramp", {}),
        ("c-axis-ramp", {"controller.kind": "lqi"}),
        ("c-axis-practical", {}),
        ("c-axis-tolerances", {}),
        ("feed-drive-line", {"controller.kind": "pid"}),
        ("feed-drive-circle", {"controller.kind": "flc"}),
        ("feed-drive-circle", {"controller.kind": "aflc"}),
    ],
)
def test_coordinates_begin_at_the_individual_and_move_all_of_it(scenario, changes):
    genome = genome_of(load_scenario(scenario, changes))
    about = genome.fresh(np.array([genome.structures // 2]), np.random.default_rng(2))
    own = coordinates(genome, about)

    def flat(population):
        return np.concatenate([x.ravel() for x in leaves(genome.gains(population))])

    same = own.members(np.zeros((1, own.size)))
    np.testing.assert_allclose(flat(same), flat(about), rtol=1e-9, atol=1e-9)
    moved = own.members(0.01 * np.random.default_rng(3).standard_normal((1, own.size)))
    assert (flat(moved) != flat(about)).mean() > 0.1
    assert (moved.tree == about.tree).all()


def leaves(tree):
    """Floating arrays of a record of records."""
    if isinstance(tree, tuple):
        return [leaf for part in tree for leaf in leaves(part)]
    known = tree is not None and np.asarray(tree).dtype.kind == "f"
    array = np.asarray(tree) if known else np.zeros(0)
    return [array[np.isfinite(array)]]


def test_a_stage_stands_as_the_individual_does():
    genome = genome_of(load_scenario("feed-drive-circle", {"controller.kind": "flc"}))
    first = taken(genome.empty(), slice(1))
    own = coordinates(genome, first)
    far = own.members(100.0 * np.eye(own.size))
    assert (far.singletons <= genome.largest_command).all()
    assert all(np.isfinite(x).all() for x in far)
