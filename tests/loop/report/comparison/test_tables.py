"""Rows of a CSV of a comparison: every design on every machine in every motion."""

from hfc_design.report.comparison.tables import rows


def test_rows_of_every_machine(spindles):
    head, *found = rows(spindles)
    assert len(found) == 2 * 2 * 9
    table = [dict(zip(head, row, strict=True)) for row in found]
    first = spindles.bouts[0].results["pd-only"]
    for row, k in ((table[0], 0), (table[5], 5)):
        assert (row["design"], row["motion"]) == ("pd-only", "c-axis-ramp")
        assert row["machine"] == k
        assert row["spindle_inertia"] == first.machines.actual[0].spindle_inertia[k]
    assert table[0]["rms_error_rad"] == first.nominal["rms_error_rad"]
    assert table[5]["rms_error_rad"] == first.values["rms_error_rad"][4]
    assert table[5]["stable"] == int(first.stable[4])


def test_parameters_of_axes_have_their_names(tables):
    head, first, *_ = rows(tables)
    row = dict(zip(head, first, strict=True))
    assert row["x_gain"] == row["y_gain"] == 40.0
    assert row["y_positive_start"] == 7.23
