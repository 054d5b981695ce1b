"""Searches that are stopped and go on."""

import pytest

from hfc_design import api

FILES = ("design.json", "history.csv", "checkpoint.npz")


class Stopped(Exception):
    pass


def whole_and_in_parts(scenario, folder, generation, files=FILES):
    """The result of a search; one that stops at ``generation`` and goes on has to equal it."""
    whole = api.design(scenario, folder / "whole")

    def stop(search):
        if search.generation == generation:
            raise Stopped

    with pytest.raises(Stopped):
        api.design(scenario, folder / "parts", stop)
    assert api.design(scenario, folder / "parts").design == whole.design
    for name in files:
        again, once = ((folder / run / name).read_bytes() for run in ("parts", "whole"))
        assert again == once, name
    return whole
