"""Logs that libraries write: a position and a command every ms, a temperature every 10 ms."""

import numpy as np
import pytest

TIME, SLOW = np.arange(400) / 1000, np.arange(40) / 100
PLACE = 3.0 * np.sin(20 * TIME)  # mm
VOLTS = np.sin(20 * TIME + 1)


def written_mdf(path, version="4.10", compression=0):
    asammdf = pytest.importorskip("asammdf")
    log, raw = asammdf.MDF(version=version), (1000 * TIME).astype("i2")
    fast = [("position", 1e3 * PLACE, "um", None), ("command", VOLTS, "V", None),
            ("count", raw, "mm", {"a": 0.5, "b": 1.0}),
            ("formula", raw, "mm", {"formula": "X1*2"})]  # fmt: skip
    slow = asammdf.Signal(SLOW, SLOW, unit="degC", name="temperature")
    log.append(slow)
    log.append([asammdf.Signal(x, TIME, name=n, unit=u, conversion=c) for n, x, u, c in fast])
    log.save(path, overwrite=True, compression=compression)


def written_tdms(path, **told):
    nptdms = pytest.importorskip("nptdms")

    def channel(group, name, values, unit, step):
        wave = {"wf_increment": step, "wf_start_offset": 0.0, "unit_string": unit}
        return nptdms.ChannelObject(group, name, values, wave | told)

    with nptdms.TdmsWriter(path) as file:
        file.write_segment([
            channel("slow", "temperature", SLOW, "degC", 1e-2),
            nptdms.ChannelObject("slow", "state", ["RUN"] * 40),
            channel("axis", "position", 1e3 * PLACE, "um", 1e-3),
            channel("drive", "command", VOLTS, "V", 1e-3),
        ])  # fmt: skip


def written_hdf5(path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file["temperature"], file["note"] = SLOW, "a text"
        file["axis/time"], file["axis/position"] = TIME, 1e3 * PLACE
        file.create_dataset("axis/command", data=VOLTS[:, None], chunks=(100, 1), compression=9)
        file["axis/position"].attrs["units"] = "um"
        file["axis/command"].attrs["unit"] = np.bytes_("V")
