"""A design's JavaScript, run in Node on rows of what it reads."""

import subprocess

import numpy as np

from hfc_design.formats.scripts import module

RUN = """
import { initial, signals, step } from "./law.mjs";
import { readFileSync, writeFileSync } from "node:fs";
const rows = readFileSync("law.in"), names = Object.keys(signals), state = initial();
const told = new Float64Array(rows.buffer, rows.byteOffset, rows.length / 8);
const count = told.length / names.length, found = [];
for (let k = 0; k < count; k += 1) {
    const inputs = Object.fromEntries(names.map((name, j) => [name, told[k * names.length + j]]));
    found.push(...[step(state, inputs)].flat());
}
writeFileSync("law.out", new Float64Array(found));
"""


def in_node(node, design, rows, folder):
    """The command of each row; of a machine those of its axes, one after the other."""
    (folder / "law.mjs").write_text(module(design))
    (folder / "law.in").write_bytes(np.asarray(rows, dtype=float).tobytes())
    (folder / "run.mjs").write_text(RUN)
    subprocess.run([node, "run.mjs"], cwd=folder, check=True)
    return np.fromfile(folder / "law.out")
