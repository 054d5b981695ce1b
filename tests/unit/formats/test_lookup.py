"""What ``--lookup`` says of its table, beside the runtime on the vectors of the folder."""

import re
from functools import cache

import numpy as np
import pytest
from deployment_folders import vectors
from sledge import hfc

from hfc_design.controllers.hierarchical.code import lookup
from hfc_design.files.loop_setup import load_design
from hfc_design.runtime import Controller

NAME = "lin-lee-1999-table-1"


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


AXES = {"plant.axes.a": "{}", "plant.axes.b": "{}", "limits.axes.b.command": 5.0}


@pytest.mark.parametrize(("points", "changes", "coarse"), [(9, AXES, True), (65, {}, False)])
def test_the_command_line_says_how_far_a_table_is_off(points, changes, coarse, tmp_path):
    told = [word for key, x in changes.items() for word in ("--change", f"{key}={x}")]
    told += ["--to", "c", "--bare", "--lookup", points, "--out", tmp_path / "c"]
    done = hfc("export", NAME, *told)
    assert done.exit_code == 0, done.output
    warning = f"hfc: warning: --lookup {points} is coarse"
    assert done.stderr.startswith(warning) if coarse else done.stderr == ""
    lines = iter(done.stdout.splitlines())
    deviation = lookup(load_design(NAME).controller, points).deviation
    for axis, limit in {"a": None, "b": 5.0}.items() if changes else [("", None)]:
        folder = tmp_path / "c" / axis
        of, off_by = next(lines), next(lines)
        far, share = re.findall(r"exact command: (\S+) V, (\S+) % of", of)[0]
        assert far == f"{deviation:.2g}"
        assert float(share) == pytest.approx(100.0 * float(far) / rules_alone(NAME), rel=0.1)
        off, largest = off_on_the_vectors(
            folder, load_design(NAME, {"limits.command": limit} if limit else None)
        )
        assert (largest == limit) if limit else largest > 5.0
        told, share = re.findall(r"off by (\S+) V at most, (\S+) % of", off_by)[0]
        assert float(told) == pytest.approx(off, rel=0.05)  # two digits are printed
        assert float(share) == pytest.approx(100.0 * off / largest, rel=0.05)
        page, (source,) = (folder / "README.md").read_text(), folder.glob("*.c")
        assert f"tabulated at {points} values" in vectors(folder)[2]
        assert of.removeprefix(f"{axis}: ") in page
        assert off_by.removeprefix(f"{axis}: ") in page
        assert "#include <math" not in source.read_text()
        assert f"{far} V" in " ".join(source.read_text().split())
