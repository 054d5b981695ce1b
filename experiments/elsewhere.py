"""What a design for c-axis-practical does in motions that it was not made for.

The table of docs/robustness.md: rms error after a second [urad], without and with the cutting load.

    python -m experiments.elsewhere runs/c-axis-practical-1
"""

from pathlib import Path
from typing import Any

import click
import numpy as np

from experiments.shared import markdown
from hfc_design import api

REFERENCES: dict[str, Any] = {
    **{f"ramp, {v:g} rad/s": {"kind": "ramp", "velocity": v} for v in (0.002, 0.02, 0.03, 0.1)},
    "sine, 0.02 rad, 2 rad/s": {"kind": "sine", "amplitude": 0.02, "frequency_rad_s": 2.0},
    **{f"step, {x:g} rad": {"kind": "step", "height": x} for x in (0.01, 0.05)},
}
WAYS: dict[str, Any] = {
    "as designed": {},
    "delay of one sample": {"limits": {"delay_samples": 1}},
    "velocity by difference": {"sensors": {"velocity": "encoder"}},
    "three times the noise": {"sensors": {"noise": 3e-6}},
}
#: Of the slowest ramp, and of all others, so much does not count [s].
SLOWEST, OTHERS, LASTS = 2.0, 1.0, 3.0


def changed(way: dict[str, Any]) -> api.Scenario:
    """The scenario with other motions, on the nominal machine."""
    data = api.load_scenario("c-axis-practical").model_dump(
        mode="json", exclude_unset=True, exclude_none=True
    )
    cutting = next(one["load"] for one in data["motions"] if one["name"] == "cutting")
    motions = []
    for k, reference in enumerate(REFERENCES.values()):
        one = {"reference": reference, "duration_s": LASTS}
        motions += [{"name": f"m{k}", **one}, {"name": f"m{k}-cutting", **one, "load": cutting}]
    data = {key: own for key, own in data.items() if key != "robust"} | {"motions": motions}
    for table, own in way.items():
        data[table] = {**data[table], **own}
        if own.get("velocity") == "encoder":
            del data[table]["observer_hz"]
    return api.load_scenario(data)


@click.command()
@click.argument("design", type=Path)
def main(design: Path) -> None:
    """Print the table, and what chatter there is [V]."""
    rows, chatter = {name: [name] for name in REFERENCES}, {}
    for way, changes in WAYS.items():
        found = api.evaluate(design, changed(changes)).motions
        change = [x.metrics["rms_voltage_change_V"] for x in found.values()]
        chatter[way] = f"{way}: {min(change):.2g} to {max(change):.2g} V from sample to sample"
        for k, name in enumerate(REFERENCES):
            after, sizes = OTHERS if k else SLOWEST, []
            for one in (found[f"m{k}"], found[f"m{k}-cutting"]):
                error = np.asarray(one.axes[0].motion.error)[one.time >= after]
                sizes.append(1e6 * float(np.sqrt(np.mean(error**2))))
            rows[name].append(" / ".join(f"{x:.3g}" for x in sizes))
    click.echo(markdown(["motion", *WAYS], [*rows.values()]))
    click.echo("\n".join(chatter.values()))


if __name__ == "__main__":
    main()
