"""Files that libraries wrote, and what ends, delays or deceives those that read them."""

import struct
import sys

import numpy as np
import pytest
from log_files import PLACE, SLOW, TIME, VOLTS, written_hdf5, written_mdf, written_tdms
from wording import refused

from hfc_design.logs import reading
from hfc_design.logs.columns import parse_columns
from hfc_design.logs.reading import read_log
from hfc_design.logs.signals import signals
from plants import PLANTS


@pytest.mark.parametrize("name", ["log.mf4", "zip.mf4", "log.mdf", "log.tdms", "log.h5"])
def test_signals_with_their_units_in_the_group_that_has_most(tmp_path, name):
    """All that is needed is sampled every ms; a temperature, which comes first, every 10 ms."""
    file = tmp_path / name
    if name.endswith(("mf4", "mdf")):
        version = "3.30" if name == "log.mdf" else "4.10"
        written_mdf(file, version, 2 if name.startswith("zip") else 0)
    else:
        (written_tdms if name.endswith("tdms") else written_hdf5)(file)
    log = read_log(file)
    even = signals(log, PLANTS["positioning-stage"], [], None)
    np.testing.assert_allclose(even.values["position"], PLACE, atol=1e-12)
    np.testing.assert_array_equal(even.values["command"], VOLTS)
    assert even.sample_time == pytest.approx(1e-3)
    assert even.notes[0].startswith("signals with other times are left out: ")
    assert "temperature" in even.notes[0]
    if name.endswith(("mf4", "mdf")):  # a conversion is applied, but no formula is evaluated
        fast = next(one for one in (log, *log.others) if "count [mm]" in one.columns)
        np.testing.assert_array_equal(fast.columns["count [mm]"], 1 + np.arange(400) / 2)
        assert fast.texts == ("formula",)
    told = parse_columns(["position=temperature [mm]"], PLANTS["positioning-stage"])
    with refused(ValueError) as found:
        signals(log, PLANTS["positioning-stage"], told, None)
    assert "at other times" in found.refusal or "command" in found.refusal


def test_dates_of_tdms_are_times_since_the_first(tmp_path):
    nptdms, begin = pytest.importorskip("nptdms"), np.datetime64("2026-12-01T03:04:05")
    dates = begin + np.round(1e6 * TIME).astype("m8[us]")
    with nptdms.TdmsWriter(tmp_path / "log.tdms") as file:
        file.write_segment([nptdms.ChannelObject("a", "Time", dates)])
    np.testing.assert_allclose(read_log(tmp_path / "log.tdms").columns["Time [s]"], TIME, atol=1e-9)


def test_hdf5_as_matlab_7_3_has_it_and_what_is_in_other_files(tmp_path):
    """Transposed columns, structs as groups, texts as numbers, behind a block of 512 bytes."""
    h5py, file = pytest.importorskip("h5py"), tmp_path / "log.mat"
    (tmp_path / "secret").write_bytes(bytes(range(100)))
    table = np.array([*zip(TIME, -TIME, strict=True)], [("t", "f8"), ("x", "f4")])
    with h5py.File(file, "w", userblock_size=512) as log:
        log["out/speed"], log["old/speed"], log["name"] = TIME[None], -TIME[None], np.zeros(9, "u2")
        log["name"].attrs["MATLAB_class"] = np.bytes_("char")
        log["both"], log["table"], log["c"] = np.c_[SLOW, -SLOW], table, 1j * TIME
        log["again"] = h5py.SoftLink("/out")
        log["elsewhere"] = h5py.ExternalLink(str(file), "/out")
        log.create_dataset("raw", (100,), "u1", external=[(str(tmp_path / "secret"), 0, 100)])
    with open(file, "r+b") as log:
        log.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    log = read_log(file)
    columns = dict(item for one in (log, *log.others) for item in one.columns.items())
    assert {*columns} == {"out.speed", "old.speed", "both_1", "both_2", "table.t", "table.x"}
    np.testing.assert_array_equal(columns["old.speed"], -TIME)
    np.testing.assert_array_equal(columns["both_2"], -SLOW)
    assert {*log.texts} == {"name", "c"}


def test_a_file_without_its_library_names_it(tmp_path, monkeypatch):
    for ending, package in (("mf4", "asammdf"), ("tdms", "nptdms"), ("hdf5", "h5py")):
        monkeypatch.setitem(sys.modules, package, None)
        file = tmp_path / f"log.{ending}"
        file.write_bytes(b"")
        with refused() as found:
            read_log(file)
        assert found.refusal.endswith(f"needs {package}; pip install 'hfc-design[logs]'")


@pytest.mark.parametrize("ending", ["mf4", "tdms", "h5"])
@pytest.mark.parametrize("length", [0, 1000])
def test_a_cut_file_is_refused_in_a_line(tmp_path, ending, length):
    """Each library says why in its words."""
    file = tmp_path / f"log.{ending}"
    {"mf4": written_mdf, "tdms": written_tdms, "h5": written_hdf5}[ending](file)
    file.write_bytes(file.read_bytes()[:length])
    with pytest.raises(Exception, match=r"is not a readable|must have") as caught:
        read_log(file)
    assert "\n" not in str(caught.value)


def test_what_a_file_declares_is_no_more_than_it_has(tmp_path, monkeypatch):
    """Rows of MDF that are not there; a billion of them; a list of groups that never ends."""
    file = tmp_path / "log.mf4"
    written_mdf(file)
    content = file.read_bytes()
    places = [k for k in range(len(content)) if content.startswith(b"##CG", k)]
    counts = [k + 32 + 8 * struct.unpack_from("<Q", content, k + 16)[0] for k in places]
    (count,) = (k for k in counts if struct.unpack_from("<Q", content, k) == (400,))
    for rows in (5000, 10**9):
        file.write_bytes(content[:count] + struct.pack("<Q", rows) + content[count + 8 :])
        if rows == 5000:
            log = read_log(file)
            assert {one.rows for one in (log, *log.others)} == {40, 400}
        else:
            with refused() as found:
                read_log(file)
            assert found.where == str(file)
    monkeypatch.setattr(reading, "LONGEST", 3)
    group = content.index(b"##DG")
    file.write_bytes(content[: group + 24] + struct.pack("<Q", group) + content[group + 32 :])
    with refused() as found:
        read_log(file)
    assert found.refusal.endswith("asammdf takes more than 3 s")
