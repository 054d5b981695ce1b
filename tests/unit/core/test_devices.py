"""When a process holds so many compiled programs that it has to forget some."""

import pytest

from hfc_design.core import devices


@pytest.mark.parametrize(("pieces", "expected"), [(5, False), (6, True)])
def test_more_than_half_of_what_may_be_mapped_is_crowded(monkeypatch, tmp_path, pieces, expected):
    (tmp_path / "maps").write_text("7f00-7f10 rw-p\n" * pieces)
    (tmp_path / "most").write_text("10\n")
    monkeypatch.setattr(devices, "MAPPED", tmp_path / "maps")
    monkeypatch.setattr(devices, "MOST_MAPPED", tmp_path / "most")
    assert devices.crowded() is expected


def test_a_system_that_counts_nothing_is_never_crowded(monkeypatch, tmp_path):
    monkeypatch.setattr(devices, "MOST_MAPPED", tmp_path / "missing")
    assert devices.crowded() is False
