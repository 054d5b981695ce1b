"""Damaged and forged checkpoints: one line, or exactly what the undisturbed run ends with.

The oracle is the run that nobody has touched. Numbers that a search could have had cannot be told
from those that it had, by whoever can compute a digest: none of these attacks forges such ones.
"""

import ast
import io
import random
import shutil
from typing import NamedTuple

import checkpoint_arrays
import checkpoint_files
import numpy as np
import pytest
from attack import FULL, SEED, Attack, rounds
from checkpoint_files import damaged, npy, plain, replaced, zipped

from hfc_design.core import archive
from hfc_design.core.records import UserError
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import run as design

SIZES = ["search.generations=6", "search.population=12"]
INPUTS = "[{name='error', scale=0.5}, {name='error_rate', scale=0.1}, {name='velocity', scale=0.1}]"
HIERARCHY = f"{{kind='pd+hierarchical-fuzzy', inputs={INPUTS}}}"
ON_LINEAR = f"controller={{inputs={INPUTS.replace('velocity', 'spindle_velocity')}, linear={{}}}}"
PER_AXIS = f"controller={{kind='per-axis', axes={{x={HIERARCHY}, y={{kind='pid'}}}}}}"
#: Scenario and changes of it; but for the first two they take long to compile: ``make attack``.
SEARCHES = {
    "pd": ("c-axis-ramp", ["controller={kind='pd'}", "simulation.duration_s=0.1"]),
    "lin-lee": ("c-axis-ramp", ["search.preset=lin-lee-1999", "simulation.duration_s=0.1"]),
    "cma": ("c-axis-ramp", [ON_LINEAR, "search.preset=cma", "simulation.duration_s=0.1"]),
    "race": ("c-axis-ramp", ["simulation.duration_s=0.1"]),
    "scheduling": (
        "c-axis-ramp",
        [
            ON_LINEAR.replace("linear=", "schedules=true, linear="),
            "search.preset=cma",
            "simulation.duration_s=0.1",
        ],
    ),
    "flc": ("feed-drive-circle", ["controller.kind=flc", "simulation.duration_s=1.0"]),
    "aflc": ("feed-drive-contour", ["controller.kind=aflc", "simulation.duration_s=1.0"]),
    "per-axis": ("feed-drive-circle", [PER_AXIS, "simulation.duration_s=1.0"]),
}
FILES = ("design.json", "history.csv", "checkpoint.npz")
#: Forgers: what each of them gives has to be refused, or may as well change nothing.
REFUSED = checkpoint_arrays.REFUSED + checkpoint_files.REFUSED
EITHER = checkpoint_arrays.EITHER + checkpoint_files.EITHER


class Base(NamedTuple):
    """A run that was broken off, and what it ends with if nobody touches it."""

    folder: object  # to be resumed
    ended: dict[str, bytes]
    content: bytes  # of the checkpoint
    name: str

    def outcome(self, content, anyway=False):
        """A word for what comes of the run with this for a checkpoint."""
        for name in FILES:
            (self.folder / name).unlink(missing_ok=True)
        (self.folder / "checkpoint.npz").write_bytes(content)
        try:
            design.run(design.opened_run(self.folder), self.folder, anyway=anyway)
        except UserError as error:
            assert (self.folder / "checkpoint.npz").read_bytes() == content
            assert not (self.folder / "design.json").exists()
            assert "checkpoint.npz: " in str(error), error
            assert str(error).isprintable(), error
            assert len(str(error)) < 600, error
            return "refused"
        assert {name: (self.folder / name).read_bytes() for name in FILES} == self.ended
        return "undisturbed"


class Stop(Exception):
    pass


def stop(search):
    if search.generation == 3:
        raise Stop


@pytest.fixture(scope="module", params=list(SEARCHES)[: None if FULL else 2])
def base(request, tmp_path_factory):
    name, changes = SEARCHES[request.param]
    scenario = load_scenario(name, [*SIZES, *changes])
    whole, part = (tmp_path_factory.mktemp("runs") / kind for kind in ("whole", "part"))
    design.run(design.new_run(scenario, whole), whole)
    own = design.new_run(scenario, part)
    with pytest.raises(Stop):
        design.run(own, part, stop)
    ended = {name: (whole / name).read_bytes() for name in FILES}
    return Base(part, ended, (part / "checkpoint.npz").read_bytes(), request.param)


def drawn(base):
    return random.Random(f"{SEED} {base.name}")


def of_version_2(content):
    """The checkpoint as an earlier version wrote it: no digest, nothing of what made it."""
    arrays = {k: v for k, v in archive.unpacked(content).items() if k != "made_by"}
    buffer = io.BytesIO()
    np.savez(buffer, **{**arrays, "format": np.array("hfc-checkpoint-2"), "config": np.array("")})
    return buffer.getvalue()


def test_damaged(base):
    """One per checkpoint of a hundred is of an earlier version, which has no digest."""
    draw, attack = drawn(base), Attack(f"damaged checkpoints: {base.name}")
    assert base.outcome(base.content) == "undisturbed"
    old = of_version_2(base.content)
    assert base.outcome(old, anyway=True) == "undisturbed"
    for k in range(rounds(100, 10_000 // len(SEARCHES) + 1)):
        earlier = k % 100 == 99
        good = content = old if earlier else base.content
        while content == good:  # zeros in place of zeros
            content = damaged(good, draw)
        outcome = attack.input(base.outcome, content, earlier)
        assert outcome == "refused" or earlier
    attack.end()


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_forged(base):
    draw, attack = drawn(base), Attack(f"crafted checkpoints: {base.name}")
    arrays = archive.unpacked(base.content)
    assert base.outcome(zipped(replaced(arrays))) == "undisturbed"
    forgers = [*REFUSED, *EITHER, *EITHER]
    for k in range(rounds(2 * len(forgers), 1000 // len(SEARCHES) + 1)):
        forger = forgers[k % len(forgers)]
        content = forger(arrays, draw)
        outcome = attack.input(base.outcome, content)
        assert outcome == "refused" or forger in EITHER, forger
    attack.end()


def test_columns_first(base):
    """NumPy writes so what lies so in memory."""
    arrays = archive.unpacked(base.content)
    turned = {
        key: npy(array.dtype.str, array.shape, array.tobytes("F"), order=True)
        for key, array in arrays.items()
    }
    assert base.outcome(zipped(replaced(turned))) == "undisturbed"


def test_what_is_no_file(base, tmp_path):
    """Nothing is read that does not end."""
    own = tmp_path / "run"
    shutil.copytree(base.folder, own)
    path = own / "checkpoint.npz"
    for make in (path.mkdir, lambda: path.symlink_to("/dev/zero"), lambda: _sparse(path)):
        path.unlink(missing_ok=True)
        make()
        with pytest.raises(UserError, match="must be a file of at most"):
            design.run(design.opened_run(own), own)
        if path.is_dir() and not path.is_symlink():
            path.rmdir()


def _sparse(path):
    with path.open("wb") as file:
        file.truncate(2**40)


def test_the_headers_here_are_what_numpy_reads():
    """The forger's own writer makes arrays that are fine where it does not lie."""
    read = np.lib.format.read_array(io.BytesIO(plain([1.0, 2.0])))
    assert read.tolist() == [1.0, 2.0]
    assert ast.literal_eval(repr({"shape": (2,)})) == {"shape": (2,)}
