"""A module of WebAssembly in Node: its functions on arrays, two machines side by side."""

import json
import subprocess

import numpy as np

RUN = """
import * as fs from "node:fs";
const calls = JSON.parse(fs.readFileSync("calls.json"));
const given = fs.readFileSync("memory.in"), memory = new WebAssembly.Memory({ initial: PAGES });
const compiled = new WebAssembly.Module(fs.readFileSync("law.wasm"));
const called = WebAssembly.Module.imports(compiled).map(({ name }) => [name, Math[name]]);
const m = { ...Object.fromEntries(called), memory };
const made = new WebAssembly.Instance(compiled, { m }).exports;
new Uint8Array(memory.buffer).set(given);
for (const [name, ...addresses] of calls) made[name](...addresses);
fs.writeFileSync("memory.out", new Uint8Array(memory.buffer, 0, given.length));
"""


def in_node(node, module, memory, calls, folder):
    """The memory (doubles) after calls, each a function and the addresses of its arrays."""
    memory = np.asarray(memory, float)
    (folder / "law.wasm").write_bytes(module)
    (folder / "memory.in").write_bytes(memory.tobytes())
    (folder / "calls.json").write_text(json.dumps(calls))
    (folder / "run.mjs").write_text(RUN.replace("PAGES", str(1 + memory.nbytes // 65536)))
    subprocess.run([node, "run.mjs"], cwd=folder, check=True)
    return np.fromfile(folder / "memory.out")
