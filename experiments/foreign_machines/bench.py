"""Drives the foreign machines: their present loops and logs, and exported designs on them.

``machine.c`` simulates, ``machines/*.toml`` describe; nothing of the package is used here but the
files that its commands write. Units of a control are mm, of rotary axes degrees.
"""

import ctypes
import re
import subprocess
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
HERE = Path(__file__).parent
SOURCE = HERE / "machine.c"
GRAVITY = 9.81
#: Of the integration [s].
STEP = 2e-5
FLAGS = ("-std=c99", "-O2", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror")
#: What a law may read, in the order of ``signals`` in machine.c.
SIGNALS = (
    *("error", "error_rate", "position", "velocity", "motor_position", "motor_velocity"),
    *("reference", "reference_rate", "reference_acceleration", "load_position", "load_velocity"),
)
TRUE, READING, MOTOR, COMMAND, OTHER = range(5)
#: So many steps of the encoder may oscillate before it is called a limit cycle, and so large a
#: share of the command's limit.
STEPS, SWING = 3.0, 0.25
MASSES = (1.0, 0.8, 1.2)
SHIM = """
#include "{name}.h"
static {name}_state state;
void begin(void) {{ {name}_init(&state); }}
double law(const double *s)
{{
    const {name}_inputs inputs = {{ {inputs} }};
    return {name}_step(&state, &inputs);
}}
"""


def fields(struct: str) -> list[str]:
    """The names of the numbers in a struct of machine.c, which holds nothing else."""
    body = re.search(r"typedef struct \{([^}]*)\} " + struct + ";", SOURCE.read_text("utf-8"))
    lists = re.findall(r"double ([\w, ]+);", body[1])
    return [name.strip() for each in lists for name in each.split(",")]


def compiled(sources: Sequence[Path], folder: Path, name: str) -> ctypes.CDLL:
    """A library of C sources in ``folder``."""
    target = folder / f"{name}.so"
    command = ["gcc", *FLAGS, *map(str, sources), "-lm", "-o", str(target)]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(target))


def simulator(folder: Path) -> ctypes.CDLL:
    """``machine.c``, compiled."""
    return compiled([SOURCE], folder, "machine")


@dataclass
class Law:
    """A controller in C, and how its control forms velocities."""

    address: Any
    begin: Any = None
    observer_hz: float = 0.0
    difference_samples: float = 1.0
    gains: Mapping[str, float] | None = None
    feedback: str | None = None  # the encoder; None: the machine's own


def exported(folder: Path, config: Mapping[str, Any], scale: bool = True) -> Law:
    """The law of ``hfc export --to c``; ``config`` is config.toml of its run.

    Raises ValueError where it reads what the machine has not, as a ``scale`` at its load.
    """
    header = next(folder.glob("*.h"))
    name = header.stem
    body = re.search(r"typedef struct \{([^}]*)\} \w+_inputs;", header.read_text("utf-8"))[1]
    members = re.findall(r"_real (\w+);", body)
    if unknown := set(members) - set(SIGNALS):
        raise ValueError(f"inputs of {header} must be among {SIGNALS} (got {sorted(unknown)})")
    own = config.get("sensors", {})
    # Beside the motor's encoder that is fed back these are of the scale.
    beside = {"position", "velocity"} if own.get("feedback") == "motor_position" else set()
    if not scale and beside & set(members):
        raise ValueError(f"inputs of {header} must be of the motor's encoder alone (got {members})")
    each = {k: SIGNALS.index(f"load_{k}" if k in beside else k) for k in members}
    inputs = ", ".join(f".{k} = s[{place}]" for k, place in each.items())
    shim = folder / "shim.c"
    shim.write_text(SHIM.format(name=name, inputs=inputs), "utf-8")
    library = compiled(sorted(folder.glob("*.c")), folder, "law")
    observer = own.get("velocity") == "observer"
    return Law(
        library.law,
        library.begin,
        observer_hz=own.get("observer_hz", 0.0) if observer else 0.0,
        difference_samples=own.get("difference_samples", 1),
        feedback=own.get("feedback"),
    )


@dataclass
class Machine:
    """One of ``machines/*.toml``."""

    name: str
    told: dict[str, Any]

    @property
    def unit(self) -> float:
        """Of the control's units in a metre, or in a radian."""
        return 180.0 / np.pi if self.told["unit"] == "deg" else 1e3

    @property
    def sample_time(self) -> float:
        """Of the control [s]."""
        return self.told["sample_time_s"]

    @property
    def grain(self) -> float:
        """The step of the encoder that is fed back [unit]."""
        at = self.told["machine"]
        step = at["motor_encoder" if at.get("fed_back") else "load_encoder"]
        return self.unit * (step + 3.0 * at.get("noise", 0.0) / STEPS)

    def parameters(self, mass: float = 1.0, **other: float) -> dict[str, float]:
        """Of machine.c, with so many times the load mass; the counterweight stays as it is."""
        found = {"torque_limit": 1e9, "presliding": 1e-6} | self.told["machine"] | other
        found["load_mass"] *= mass
        if self.told.get("vertical"):
            found["pull"] = GRAVITY * (found["load_mass"] - self.told["counterweight_kg"])
        return found


def machines() -> dict[str, Machine]:
    """All of them by name."""
    files = sorted((HERE / "machines").glob("*.toml"))
    every = [tomllib.loads(file.read_text(encoding="utf-8")) for file in files]
    return {name: Machine(name, own) for told in every for name, own in told.items()}


def simulated(
    program: ctypes.CDLL,
    parameters: Mapping[str, float],
    law: Law,
    reference: Floats,
    sample_time: float,
    unit: float,
    added: Floats | None = None,
) -> Floats:
    """What a loop does: (samples, 5), the columns ``TRUE`` to ``OTHER``; nan where it ran away.

    ``reference`` is (samples, 3) [unit], [unit/s], [unit/s2]; ``added`` comes to the command [V].
    """
    if law.begin is not None:
        law.begin()
    numbers = dict(parameters)
    if law.feedback is not None:
        numbers["fed_back"] = float(law.feedback == "motor_position")
    sensing = {
        "observer_hz": law.observer_hz,
        "difference_samples": law.difference_samples,
        "unit": unit,
    }
    extra = np.zeros(len(reference)) if added is None else added
    out = np.full((len(reference), 5), np.nan)
    held = [np.ascontiguousarray(x, np.float64) for x in (reference, extra)]
    program.run(
        packed("machine", numbers),
        packed("sensing", sensing),
        packed("pid_gains", law.gains or {}),
        law.address,
        len(reference),
        ctypes.c_double(sample_time),
        max(round(sample_time / STEP), 1),
        *(x.ctypes.data_as(ctypes.c_void_p) for x in (*held, out)),
    )
    return out


def packed(struct: str, numbers: Mapping[str, float]) -> Any:
    """The numbers of a struct of machine.c; what is left out is 0."""
    names = fields(struct)
    if unknown := set(numbers) - set(names):
        raise ValueError(f"{struct} must have fields of machine.c (got {sorted(unknown)})")
    return (ctypes.c_double * len(names))(*(numbers.get(name, 0.0) for name in names))


def present(program: ctypes.CDLL, machine: Machine) -> Law:
    """The PID that runs on the machine today."""
    return Law(program.pid, gains=machine.told["loop"])


def trapezoid(time: Floats, distance: float, velocity: float, acceleration: float) -> Floats:
    """A move from rest to rest, then hold: (samples, 3); no way is a rest."""
    if not distance:
        return np.zeros((len(time), 3))
    way, sign = abs(distance), np.sign(distance)
    velocity = min(velocity, np.sqrt(way * acceleration))
    rise, whole = velocity / acceleration, way / velocity + velocity / acceleration
    up, down = np.clip(time, 0, rise), np.clip(whole - time, 0, rise)
    flat = np.clip(time - rise, 0, whole - 2 * rise)
    place = 0.5 * acceleration * (up**2 + rise**2 - down**2) + velocity * flat
    rate = acceleration * np.minimum(up, down)
    ends = (time >= whole - rise) & (time < whole)
    change = acceleration * (1.0 * (time < rise) - ends)
    return sign * np.stack([place, rate, change], axis=1)


def moved(moves: Sequence[tuple[float, float, float, float]], sample_time: float) -> Floats:
    """Moves one after the other, each (distance, velocity, acceleration, rest behind it [s])."""
    parts, place = [], 0.0
    for distance, velocity, acceleration, rest in moves:
        fastest = min(velocity, np.sqrt(abs(distance) * acceleration))
        seconds = (abs(distance) / fastest + fastest / acceleration if distance else 0.0) + rest
        time = sample_time * np.arange(round(seconds / sample_time))
        own = trapezoid(time, distance, velocity, acceleration)
        parts.append(own + np.array([place, 0.0, 0.0]))
        place += distance
    return np.concatenate(parts)


def commissioning(machine: Machine) -> tuple[Floats, Floats]:
    """The reference of the log's run, and what is added to the command in its last, slow moves."""
    own, time = machine.told["run"], machine.sample_time
    far, fast, rise, slow = (own[key] for key in ("distance", "velocity", "acceleration", "slow"))
    first = [(0.0, 1.0, 1.0, 0.5), (far, fast, rise, 0.3), (-far, fast / 2, rise / 2, 0.3)]
    first += [(s * slow, slow, rise, 0.2) for s in (1, -1, 1, -1)]
    first += [(s * far / 8, fast / 4, rise, 0.0) for s in (1, -1, 1, -1)]
    last = [(s * 2.0 * slow, slow, rise, 0.1) for s in (1, -1)]
    before, reference = moved(first, time), moved([*first, *last, (0.0, 1.0, 1.0, 0.3)], time)
    added = np.zeros(len(reference))
    count = len(reference) - len(before)
    low, high = own["excited_hz"]
    tones = np.arange(low, high, 0.5)
    phases = np.random.default_rng(len(machine.name)).uniform(0, 2 * np.pi, len(tones))
    now = time * np.arange(count)
    noise = np.sin(2 * np.pi * tones * now[:, None] + phases).sum(axis=1)
    added[len(before) :] = own["excitation"] * noise / np.std(noise)
    return reference, added


def write_log(program: ctypes.CDLL, machine: Machine, file: Path) -> None:
    """The commissioning run of the present loop, as the drive's scope writes it."""
    reference, added = commissioning(machine)
    own, law = machine.parameters(), present(program, machine)
    found = simulated(program, own, law, reference, machine.sample_time, machine.unit, added)
    columns = {
        "time": machine.sample_time * np.arange(len(found)),
        "position": found[:, READING],
        "reference": reference[:, 0],
        "motor_position": found[:, MOTOR],
        "command": found[:, COMMAND],
    }
    told = machine.told["log"]
    lines = list(told["head"])
    rows = [
        [f"{x:.{digits}f}" for x in factor * columns[name]]
        for name, factor, digits in told["columns"]
    ]
    each = (told["separator"].join(row) for row in zip(*rows, strict=True))
    lines += (line.replace(".", told["decimal"]) for line in each)
    file.write_text("\n".join([*lines, ""]), "utf-8", newline="\n")


@dataclass
class Found:
    """What a motion came to."""

    motion: str
    mass: float
    rms: float
    settled_rms: float
    swing: float  # amplitude of what oscillates in the last quarter, in steps of the encoder
    at_limit: float  # share of the last quarter
    cycle: bool  # that is a limit cycle


def oscillation(values: Floats) -> float:
    """The amplitude of what goes on oscillating; 0 with fewer than three swings.

    A parabola is taken off first; a swing goes through a half of the amplitude on both sides, and
    that of the second half counts, so that what dies out counts for less.
    """
    time = np.linspace(-1.0, 1.0, len(values))
    left = values - np.polyval(np.polyfit(time, values, 2), time)
    amplitude = 0.5 * np.ptp(left)
    outside = left[np.abs(left) > 0.5 * amplitude]
    turns = np.count_nonzero(np.diff(np.sign(outside)))
    return 0.5 * float(np.ptp(left[len(left) // 2 :])) if turns >= 6 else 0.0


def judged(
    machine: Machine,
    motion: str,
    mass: float,
    error: Floats,
    command: Floats,
    settled: int,
    steady: bool,
) -> Found:
    """What the samples of a motion say; only a ``steady`` end shows a limit cycle."""
    quarter = slice(3 * len(error) // 4, None)
    limit = machine.told["machine"]["command_limit"]
    if not np.all(np.isfinite(error)):
        return Found(motion, mass, np.inf, np.inf, np.inf, 1.0, True)
    swing = oscillation(error[quarter]) / machine.grain if steady else 0.0
    beats = oscillation(command[quarter]) / limit if steady else 0.0
    at_limit = float(np.mean(np.abs(command[quarter]) > 0.999 * limit))
    rms, settled_rms = (float(np.sqrt(np.mean(e**2))) for e in (error, error[settled:]))
    return Found(motion, mass, rms, settled_rms, swing, at_limit, swing > STEPS or beats > SWING)


def own_motions(machine: Machine) -> dict[str, Floats]:
    """Rest, ramp, step and reversal of three seconds, at rest or at a steady speed in the end."""
    time, own = machine.sample_time, machine.told["run"]
    count = round(3.0 / time)
    rest, ramp, step = (np.zeros((count, 3)) for _ in range(3))
    rest[:, 0] = 10.5 * machine.grain
    ramp[:, 0], ramp[:, 1] = own["slow"] * time * np.arange(count), own["slow"]
    step[:, 0] = own["slow"] / 20.0
    fast, rise = 2.0 * own["slow"], own["acceleration"]
    back = moved([(s * own["slow"], fast, rise, 0.0) for s in (1, -1)], time)
    hold = np.zeros((count - len(back), 3))
    return {"rest": rest, "ramp": ramp, "step": step, "reversal": np.concatenate([back, hold])}


def scenario_motions(
    config: Mapping[str, Any], sample_time: float
) -> dict[str, tuple[Floats, float, bool]]:
    """Of config.toml: samples, from when one counts as settled [s], whether it ends steadily."""
    found = {}
    for one in config.get("motions") or [{"name": "motion"}]:
        whole = {**config, **one}
        seconds = one.get("duration_s", config["simulation"]["duration_s"])
        time = sample_time * np.arange(round(seconds / sample_time))
        still = np.zeros_like(time)
        match whole["reference"]:
            case {"kind": "ramp", "velocity": v}:
                samples = np.stack([v * time, still + v, still], axis=1)
            case {"kind": "step", "height": height}:
                begun = time >= whole["reference"].get("time_s", 0.0)
                samples = np.stack([height * begun, still, still], axis=1)
            case {"kind": "sine", "amplitude": a, "frequency_rad_s": w}:
                parts = np.sin(w * time), w * np.cos(w * time), -w * w * np.sin(w * time)
                samples = a * np.stack(parts, axis=1)
            case {"kind": "trapezoidal", "distance": d, "velocity": v, "acceleration": a}:
                samples = trapezoid(time, d, v, a)
            case other:
                raise ValueError(f"reference must be one of the bench's (got {other})")
        settled = one.get("settled_after_s", config["fitness"].get("settled_after_s", 0.0))
        ends = samples[3 * len(samples) // 4 :, 2]
        found[one["name"]] = samples, settled, not np.any(ends)
    return found


def tried(
    program: ctypes.CDLL, machine: Machine, law: Law, config: Mapping[str, Any]
) -> list[Found]:
    """An exported design in the bench's own motions, its scenario's and these backwards.

    With three masses.
    """
    time = machine.sample_time
    motions = {k: (x, 0.0, True) for k, x in own_motions(machine).items()}
    for name, (reference, *rest) in scenario_motions(config, time).items():
        motions |= {f"scenario {name}": (reference, *rest), f"back {name}": (-reference, *rest)}
    found = []
    for mass in MASSES:
        for name, (reference, settled, steady) in motions.items():
            own = machine.parameters(mass)
            did = simulated(program, own, law, reference, time, machine.unit)
            error = reference[:, 0] - did[:, TRUE]
            begin = min(round(settled / time), len(error) - 1)
            found.append(judged(machine, name, mass, error, did[:, COMMAND], begin, steady))
    return found
