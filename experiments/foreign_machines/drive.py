"""From the log of each foreign machine to its controller in C, by four commands, and onto it.

python -m experiments.foreign_machines.drive [NAME ...] [--seed N] [--out FOLDER]
"""

import json
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from time import monotonic
from typing import Any

import click
import numpy as np

from experiments.foreign_machines import bench
from experiments.shared import markdown

HFC = (sys.executable, "-c", "from hfc_design.cli import main; main()")
HEAD = (
    *("machine", "plant", "answer", "rms promised", "rms found", "found / promised (worst)"),
    *("limit cycle", "at limit", "minutes"),
)


def asked(machine: bench.Machine, log: Path, out: Path) -> list[str]:
    """The command line that identifies the machine, as a user writes it from the documents."""
    told = machine.told
    columns = [f"--column={x}" for x in told["log"]["names"]]
    known = [f"--set=plant.parameters.{key}={x}" for key, x in told["know"].items()]
    known += [f"--set={words}" for words in told.get("set", [])]
    if "load_encoder" not in told["machine"]:
        known.append("--set=stress.encoder_at=drive")
    free = ["--free", told["free"]] if "free" in told else []
    return [
        "identify",
        str(log),
        "--plant",
        told["plant"],
        *columns,
        *known,
        *free,
        "--out",
        str(out),
    ]


def hfc(folder: Path, words: Sequence[str]) -> bool:
    """Whether a command succeeds; what it prints is kept in the folder, by its first word."""
    done = subprocess.run([*HFC, *words], check=False, capture_output=True, text=True)
    told = f"$ hfc {' '.join(words)}\n{done.stdout}{done.stderr}"
    (folder / f"{words[0]}.txt").write_text(told, "utf-8")
    return not done.returncode


def row(program: Any, machine: bench.Machine, folder: Path, seed: int) -> list[str]:
    """All of one machine: a line of ``HEAD``."""
    begun = monotonic()
    folder.mkdir(parents=True)
    log, mine = folder / "log.csv", folder / "mine"
    bench.write_log(program, machine, log)
    run, code = mine / "run", mine / "c"
    commands = [
        [*asked(machine, log, mine), "--seed", str(seed)],
        ["design", str(mine / "scenario.toml"), "--seed", str(seed), "--out", str(run)],
        ["export", str(run), "--to", "c", "--out", str(code)],
    ]
    for words in commands:
        if not hfc(folder, words):
            lines = (folder / f"{words[0]}.txt").read_text("utf-8").strip().splitlines()
            last = next((x for x in reversed(lines) if x.startswith("hfc:") or "Error:" in x), "")
            return [machine.name, machine.told["plant"], f"hfc {words[0]}: {last}", *["–"] * 6]
    subprocess.run(["make", "-s", "-C", str(code), "check"], check=True, capture_output=True)
    config = tomllib.loads((run / "config.toml").read_text("utf-8"))
    usable = json.loads((run / "usable.json").read_text("utf-8"))
    try:
        law = bench.exported(code, config, "load_encoder" in machine.told["machine"])
    except ValueError as error:
        return [machine.name, machine.told["plant"], str(error), *["–"] * 6]
    found = bench.tried(program, machine, law, config)
    kept = {"answer": usable["answer"], "motions": [vars(one) for one in found]}
    (folder / "found.json").write_text(json.dumps(kept, indent=1), "utf-8")
    cells = told(machine, usable, found)
    return [*cells, f"{(monotonic() - begun) / 60:.1f}"]


def told(machine: bench.Machine, usable: Any, found: Sequence[bench.Found]) -> list[str]:
    """The line but for the time; rms errors are root mean squares over the scenario's motions."""
    promised, did = {}, {}
    for one in found:
        if one.mass == 1.0 and one.motion.startswith("scenario "):
            name = one.motion.removeprefix("scenario ")
            promised[name] = usable["motions"][name]["tolerances"]["rms_error"]["nominal"]
            did[name] = one.rms
    sizes = [float(np.sqrt(np.mean(np.square([*each.values()])))) for each in (promised, did)]
    ratios = {name: did[name] / promised[name] for name in did}
    worst = max(ratios, key=lambda name: abs(np.log(ratios[name])))
    answer = usable.get("verdict") or usable["answer"].split(":")[0]
    unit = "mdeg" if machine.told["unit"] == "deg" else "um"

    def where(bad: list[bench.Found]) -> str:
        names = dict.fromkeys(f"{one.motion} x{one.mass:g}" for one in bad)
        return f"yes: {', '.join([*names][:3])}{' ...' if len(names) > 3 else ''}" if bad else "no"

    return [
        *(machine.name, machine.told["plant"], answer),
        *(f"{1e3 * x:.3g} {unit}" for x in sizes),
        f"{sizes[1] / sizes[0]:.2f} ({worst} {ratios[worst]:.2f})",
        where([one for one in found if one.cycle]),
        where([one for one in found if one.at_limit > 0.1]),
    ]


@click.command()
@click.argument("names", nargs=-1)
@click.option("--seed", type=int, default=1, help="Of the starts and of the search.")
@click.option("--out", type=Path, default=Path("runs/foreign"), help="A new folder.")
def main(names: tuple[str, ...], seed: int, out: Path) -> None:
    """Print a table with a row of each machine, all without NAMES."""
    out.mkdir(parents=True, exist_ok=True)
    program, every = bench.simulator(out), bench.machines()
    lines = []
    for name in names or every:
        lines.append(row(program, every[name], out / f"{name}-{seed}", seed))
        print(markdown(HEAD, lines[-1:]), flush=True)
    (out / f"table-{seed}.md").write_text(markdown(HEAD, lines), "utf-8")


if __name__ == "__main__":
    main()
