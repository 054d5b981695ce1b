"""What ``--lookup`` says of its table, beside the runtime on the vectors of the folder."""

import re
from functools import cache

import numpy as np
import pytest
from flash_folders import vectors
from sledge import hfc

from hfc_design.controllers.hierarchical.code import lookup
from hfc_design.files.pairing import load_design
from hfc_design.runtime import Controller

NAME = "lin-lee-1999-table-1"


def export(folder, points, *changes):
    told = [word for change in changes for word in ("--change", change)]
    done = hfc("export", NAME, *told, "--to", "c", "--lookup", points, "--out", folder)
    assert done.exit_code == 0, done.output
    return done


def off_on_the_vectors(folder, design):
    """Largest difference of the commands there from the design's own, and the largest of those."""
    names, numbers, _ = vectors(folder)
    controller = Controller(design)
    own = []
    for row in numbers:
        if row[0]:
            controller.reset()
        own.append(controller.step(dict(zip(names[2:-1], row[2:-1].tolist(), strict=True))))
    return np.abs(np.array(own) - numbers[:, -1]).max(), np.abs(numbers[:, -1]).max()


@cache
def rules_alone(design):
    """The largest command of a design without gains, for anything within its ranges."""
    bare = load_design(design, {"controller.pd": {"kp": 0.0, "kd": 0.0}})
    random = np.random.default_rng(3)
    controller, found = Controller(bare), 0.0
    reach = {item.name: 1.0 / item.scale for item in bare.controller.inputs}
    for _ in range(3000):
        told = {name: float(size * random.uniform(-1, 1)) for name, size in reach.items()}
        controller.remember({"spindle_velocity": told["previous_spindle_velocity"]})
        found = max(found, abs(controller.step(told | {"error_rate": 0.0})))
    return found


@pytest.mark.parametrize(
    ("points", "limit", "coarse"), [(9, None, True), (9, 5.0, True), (65, None, False)]
)
def test_the_command_line_says_how_far_the_table_is_off(points, limit, coarse, tmp_path):
    changes = [f"limits.command={limit}"] if limit else []
    design = load_design(NAME, changes)
    done = export(tmp_path / "c", points, *changes)
    off, largest = off_on_the_vectors(tmp_path / "c", design)
    told, share = re.findall(r"off by (\S+) V at most, (\S+) per cent of", done.stdout)[0]
    assert float(told) == pytest.approx(off, rel=0.05)  # two digits are printed
    assert float(share) == pytest.approx(100.0 * off / (limit or largest), rel=0.05)
    far, share = re.findall(r"exact command: (\S+) V, (\S+) per cent of", done.stdout)[0]
    assert far == f"{lookup(design.controller, points).deviation:.2g}"
    assert float(share) == pytest.approx(100.0 * float(far) / rules_alone(NAME), rel=0.1)
    warning = f"hfc: warning: --lookup {points} is coarse"
    assert done.stderr.startswith(warning) if coarse else done.stderr == ""
    page = (tmp_path / "c" / "README.md").read_text()
    for line in done.stdout.splitlines()[:2]:
        assert line in page
    text = (tmp_path / "c" / "lin_lee_1999_table_1.c").read_text()
    assert "#include <" not in text
    assert f"{far} V" in " ".join(text.split())
