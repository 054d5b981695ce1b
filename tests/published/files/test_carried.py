"""A design takes along the files that its scenario names: it can be used in any folder."""

import pytest
from run_folders import hfc


@pytest.mark.parametrize(
    "command",
    [
        ["score", "mine.json"],
        ["score", "mine.json", "--spread", "0.1", "--samples", "8"],
        ["compare", "mine.json", "pd-only", "--out", "beside"],
    ],
)
def test_it_is_judged_without_its_files(command, carried):
    done = hfc(*command)
    assert done.exit_code == 0, done.output
