"""Test vectors are those of the runtime, go beyond every range, and find a wrong number."""

import numpy as np
import pytest
from flash_folders import ALL, vectors, written


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return written(tmp_path_factory.mktemp)


@pytest.mark.parametrize("name", ["jee-koren-2004-flc", "jee-koren-1995-fit-flc"])
def test_every_rule_of_a_table_fires(name, folder):
    """Judged by centres: error and its change come nearer to those of every rule than the next."""
    names, numbers, _ = vectors(folder(name))
    record = ALL[name].controller
    error = numbers[:, names.index("error")]
    places = []
    for terms, values in (
        (record.error_terms, error),
        (record.error_change_terms, np.diff(error, prepend=0.0)),
    ):
        centres = np.array([term.centre for term in terms])
        places.append(np.abs(values[:, None] - centres).argmin(axis=1))
    assert len(set(zip(*places, strict=True))) == len(record.error_terms) * len(
        record.error_change_terms
    )
