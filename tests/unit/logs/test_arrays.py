"""Arrays that NumPy and SciPy wrote, and what pretends to be such."""

import zipfile

import numpy as np
import pytest
from scipy.io import savemat
from wording import refused

from hfc_design.core.records import UserError
from hfc_design.logs import arrays
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


def test_nothing_is_unpickled(tmp_path):
    file = tmp_path / "log.npy"
    np.save(file, np.array([print, TIME], dtype=object), allow_pickle=True)
    with pytest.raises(UserError, match=r"is no file of NumPy that can be read.*pickle"):
        read_log(file)


def test_what_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(arrays, "MOST_NUMBERS", 100)
    np.savez_compressed(tmp_path / "log.npz", x=np.zeros(1000))
    savemat(tmp_path / "log.mat", {"x": np.zeros(1000)}, do_compression=True)
    for name in ("log.npz", "log.mat"):
        with refused() as found:
            read_log(tmp_path / name)
        assert found.where == str(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("log.mat", b""),
        ("log.mat", b"MATLAB 5.0 MAT-file" + bytes(200)),
        ("log.npy", b"\x93NUMPY\x01\x00"),
        ("log.npz", b"PK\x03\x04"),
    ],
)
def test_damaged_files_are_refused_in_a_line(tmp_path, name, content):
    """NumPy and SciPy say why, each version in its words."""
    file = tmp_path / name
    file.write_bytes(content)
    with pytest.raises(UserError) as caught:
        read_log(file)
    kind = "MAT file" if name == "log.mat" else "file of NumPy"
    assert str(caught.value).startswith(f"{file}: is no {kind} that can be read: ")
    assert "\n" not in str(caught.value)


def test_a_file_of_matlab_7_3_is_refused(tmp_path):
    (tmp_path / "log.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform")
    with refused() as found:
        read_log(tmp_path / "log.mat")
    assert found.where == str(tmp_path / "log.mat")


def test_an_empty_archive_has_no_column(tmp_path):
    with zipfile.ZipFile(tmp_path / "log.npz", "w"):
        pass
    with refused() as found:
        read_log(tmp_path / "log.npz")
    assert found.where == str(tmp_path / "log.npz")
