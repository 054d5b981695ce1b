"""Arrays that NumPy and SciPy wrote, and what pretends to be such."""

import numpy as np
import pytest
from scipy.io import loadmat, savemat
from wording import refused

from hfc_design.core.records import UserError
from hfc_design.logs import reading
from hfc_design.logs.reading import read_log

TIME = np.arange(40) / 1000


def test_mat_keeps_vectors_and_leaves_settings(tmp_path):
    file = tmp_path / "log.mat"
    data = {"t": TIME[:, None], "qm": TIME**2, "kp": 160.18, "name": "stage", "gains": [1.0, 2.0]}
    savemat(file, data, do_compression=True)
    log = read_log(file)
    assert {*log.columns} == {"t", "qm"}
    np.testing.assert_array_equal(log.columns["qm"], TIME**2)


def test_numpy_arrays_with_and_without_names(tmp_path):
    np.savez(tmp_path / "log.npz", t=TIME, x=-TIME)
    np.testing.assert_array_equal(read_log(tmp_path / "log.npz").columns["x"], -TIME)
    np.save(tmp_path / "log.npy", np.stack([TIME, -TIME], axis=1))
    np.testing.assert_array_equal(read_log(tmp_path / "log.npy").columns["column_2"], -TIME)
    named = np.array([*zip(TIME, -TIME, strict=True)], dtype=[("t", float), ("x", float)])
    np.save(tmp_path / "log.npy", named)
    np.testing.assert_array_equal(read_log(tmp_path / "log.npy").columns["x"], -TIME)


def test_what_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "MOST_NUMBERS", 100)
    np.savez_compressed(tmp_path / "log.npz", x=np.zeros(1000))
    savemat(tmp_path / "log.mat", {"x": np.zeros(1000)}, do_compression=True)
    for name in ("log.npz", "log.mat"):
        with refused() as found:
            read_log(tmp_path / name)
        assert found.where == str(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("log.mat", b"MATLAB 5.0 MAT-file" + bytes(200)),
        ("log.mat", (b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + b"\x0e\0\0\0\xff\0\0\0")),
        ("log.npz", b"PK\x03\x04"),
    ],
)
def test_damaged_files_are_refused_in_a_line(tmp_path, name, content):
    """NumPy and SciPy say why, each version in its words."""
    file = tmp_path / name
    file.write_bytes(content)
    with pytest.raises(UserError) as caught:
        read_log(file)
    kind = "MAT file" if name == "log.mat" else "NumPy file"
    assert str(caught.value).startswith(f"{file}: is not a readable {kind}: ")
    assert "\n" not in str(caught.value)


def test_a_file_of_an_old_matlab(tmp_path):
    savemat(tmp_path / "log.mat", {"t": TIME, "x": -TIME}, format="4")
    np.testing.assert_array_equal(read_log(tmp_path / "log.mat").columns["x"], -TIME)


@pytest.mark.parametrize("compressed", [True, False])
def test_structs_of_simulink_are_read(tmp_path, compressed):
    """As To Workspace saves them; what else is a struct has dotted names."""
    signals = np.array(
        [(TIME[:, None] ** 2, "position"), (np.c_[TIME, -TIME], "u"), (3 * TIME[:, None], "")],
        dtype=[("values", object), ("label", object)],
    )
    out = {"time": TIME[:, None], "signals": signals, "blockName": "m/To Workspace"}
    series = {"Time": TIME[:, None], "Data": 5 * TIME[:, None], "Name": "v"}
    file = tmp_path / "log.mat"
    deep = {"a": {"b": 7 * TIME, "n": 1.0}, "note": "é"}
    data = {"out": out, "speed": series, "own": deep, "cells": np.array([TIME, 1], object)}
    savemat(file, data | {"wide": TIME.astype("f4"), "c": 1j * TIME}, do_compression=compressed)
    log = read_log(file)
    factors = {"time": 1, "u_1": 1, "u_2": -1, "out.signals(3)": 3, "speed": 5, "own.a.b": 7}
    assert {*log.columns} == {*factors, "position", "wide"}
    for name, factor in factors.items():
        np.testing.assert_array_equal(log.columns[name], factor * TIME)
    np.testing.assert_array_equal(log.columns["position"], TIME**2)
    np.testing.assert_array_equal(log.columns["wide"], TIME.astype("f4"))
    assert log.texts == ("cells", "c")
    savemat(file, {"x": data["cells"]})
    with refused() as found:
        read_log(file)
    assert found.where == str(file)


def test_an_object_is_named(tmp_path):
    """A timeseries as MATLAB saves it: SciPy reads its name and class, no more."""
    words = [bytes.fromhex("06000000 08000000 11000000 00000000")]
    for text in ("speed", "MCOS", "timeseries"):
        words.append(bytes([1, 0, 0, 0, len(text), 0, 0, 0]) + text.encode().ljust(16, b"\0"))
        words[-1] = words[-1][: 8 + -(-len(text) // 8) * 8]
    savemat(tmp_path / "log.mat", {"x": [1.0]})
    content = (tmp_path / "log.mat").read_bytes()
    inside = b"".join(words) + content[128:]
    file = tmp_path / "log.mat"
    file.write_bytes(content[:132] + len(inside).to_bytes(4, "little") + inside)
    (known,) = (v for v in loadmat(file).values() if isinstance(v, np.ndarray))
    assert known[0].tolist()[:3] == (b"speed", b"MCOS", b"timeseries")
    with refused() as found:
        read_log(file)
    assert "speed.Data" in found.refusal


@pytest.mark.parametrize("kind", ["f8", "f4", "i1", "i8", "u8", "?"])
def test_numbers_of_every_type_are_what_scipy_reads(tmp_path, kind):
    """Under names short and long."""
    file, values = tmp_path / "log.mat", (np.arange(40) % 7).astype(kind)
    savemat(file, {"t": TIME, "x": values, "a_long_name": values[::-1]})
    read = loadmat(file)
    for name, column in read_log(file).columns.items():
        np.testing.assert_array_equal(column, read[name].ravel())


def test_numbers_whose_largest_byte_is_first(tmp_path):
    """As a Sun had them: the words of a file turned, but for its texts and numbers of 8 bytes."""
    file = tmp_path / "log.mat"
    savemat(file, {"abcd": TIME})
    content = file.read_bytes()
    words = np.frombuffer(content[128:184], "<u4").byteswap().tobytes()
    head = content[:124] + b"\1\0MI" + words[:40] + b"\0\4\0\1abcd" + words[48:]
    file.write_bytes(head + TIME.astype(">f8").tobytes())
    np.testing.assert_array_equal(read_log(file).columns["abcd"], TIME)
    np.testing.assert_array_equal(loadmat(file)["abcd"].ravel(), TIME)


def test_what_is_no_list_of_columns_is_refused(tmp_path):
    """An array of three sizes; a single row is a vector."""
    file = tmp_path / "log.npy"
    np.save(file, np.zeros((2, 30, 2)))
    with refused() as found:
        read_log(file)
    assert found.where == str(file)
    for vector in (TIME, TIME[None]):
        np.save(file, vector)
        np.testing.assert_array_equal(read_log(file).columns["column_1"], TIME)
