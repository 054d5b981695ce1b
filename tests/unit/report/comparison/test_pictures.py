"""Curves for a page keep every extreme; numbers of logarithmic axes stand apart."""

import numpy as np
import pytest
from read_figures import read_apart

from hfc_design.pictures.figure import framed
from hfc_design.report.comparison.plots import _few_decades
from hfc_design.report.comparison.traces import extremes


@pytest.mark.parametrize("count", [1, 7, 1200, 1201, 10_000, 12_345])
def test_no_extreme_is_lost(count):
    values = np.random.default_rng(count).normal(size=count)
    found, size = extremes(values)
    assert len(found) <= 1200 or size == 1
    assert found.min() == values.min()
    assert found.max() == values.max()
    for k in range(0, len(found) - 1, 2) if size > 1 else ():
        own = values[k // 2 * size : (k // 2 + 1) * size]
        assert set(found[k : k + 2]) == {own.min(), own.max()}
        if own.argmin() != own.argmax():
            assert (found[k] == own.min()) == (own.argmin() < own.argmax())


def test_what_has_run_away_is_a_gap():
    values = np.arange(6000.0)
    values[3001:] = np.nan
    found, _ = extremes(values)
    assert np.nanmax(found) == 3000.0
    assert np.isnan(found[602:]).all()


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        (160.0, 750.0, [f"{100 * k}" for k in range(2, 8)]),  # of 1, 2, 5 there are too few
        (15.0, 420.0, ["20", "50", "100", "200"]),
        (0.9, 1.35, ["0.9", "1", "1.1", "1.2", "1.3"]),
        (12.0, 4e4, [rf"$\mathdefault{{10^{{{k}}}}}$" for k in (2, 3, 4)]),
    ],
)
def test_numbers_of_a_logarithmic_axis_stand_apart(low, high, told):
    figure = framed(1.5, top=0.1, left=1.0, right=0.5)
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    _few_decades(axes)
    assert read_apart(figure, axes) == told
