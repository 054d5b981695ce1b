"""Reports of runs whose scores, metrics and motions are 0, infinite, tiny, huge or no number."""

import csv
import json
import shutil
from pathlib import Path

import jax
import numpy as np
import pytest
from attack import SEED, Attack, rounds
from run_folders import batch_folder

from hfc_design.batch.report import report
from hfc_design.files.loop_setup import load_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.page import write_page
from hfc_design.runs.run import Result, new_run
from hfc_design.simulation.evaluating import evaluate

#: Among them what divides by zero, overflows when squared, and has no logarithm or inverse.
EXTREMES = (0.0, -0.0, 5e-324, 1e-320, 1e-300, 1.0, -1.0, 1e154, 1e300, 1.7e308, -1.7e308)
NO_NUMBERS = (np.inf, -np.inf, np.nan)
METRICS = ("rms_error_rad", "settling_time_s")


def drawn(random, count, values=EXTREMES):
    return random.choice(values, count) if random.random() < 0.8 else random.normal(size=count)


@pytest.mark.filterwarnings("default")  # numbers may overflow; the report has to be there
def test_the_report_of_many_runs(tmp_path):
    random, attack = np.random.default_rng(SEED), Attack("report of a batch")

    def reported(out):
        settings = [{"scenario": "a", "search.preset": name} for name in ("one", "two", "three")]
        values = [drawn(random, 4).tolist() for _ in settings]
        names = batch_folder(out, list(zip(settings, values, strict=True)))
        for name in names:
            path = out / name / "design.json"
            design = json.loads(path.read_text())
            found = drawn(random, 3, (*EXTREMES, *NO_NUMBERS))
            design["score"] |= dict(zip(("merit", *METRICS), found.tolist(), strict=True))
            path.write_text(json.dumps(design))
            best = np.maximum.accumulate(drawn(random, 5, (*EXTREMES, np.nan))).tolist()
            rows = [f"{k},{value!r},{value!r},0,5" for k, value in enumerate(best)]
            head = "generation,best,median,diverged,structures"
            (out / name / "history.csv").write_text("\n".join([head, *rows, ""]))
        sides = ({"of": settings[0]}, {"of": settings[0], "over": settings[1]})
        figures = [
            {"quantity": "x", "value": value, "metric": metric, **side}
            for value, side, metric in zip(drawn(random, 6), sides * 3, METRICS * 3, strict=True)
        ]
        plan = json.loads((out / "batch.json").read_text())
        plan["files"] = {"mine": {"published": figures}}
        (out / "batch.json").write_text(json.dumps(plan))
        report(out)
        for table in ("runs.csv", "groups.csv", "published.csv"):
            with (out / table).open(newline="") as file:
                cells = [cell for row in csv.reader(file) for cell in row]
            if table == "published.csv":
                assert not {"inf", "-inf", "nan"} & set(cells), cells
        assert (out / "report.html").stat().st_size > 10_000
        shutil.rmtree(out)
        return "written"

    for k in range(rounds(2, 60)):
        attack.input(reported, tmp_path / str(k))
    attack.end()


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(
    ("name", "of"),
    [("c-axis-ramp", "lin-lee-1999-table-1"), ("feed-drive-circle", "jee-koren-2004-flc")],
)
def test_the_report_of_a_run(name, of, tmp_path):
    random, attack = np.random.default_rng(SEED), Attack(f"report of a run of {name}")
    scenario = load_scenario(name, {"simulation.duration_s": 0.5})
    given, folder = load_design(of), tmp_path / "run"
    new_run(scenario, folder, given)
    true = evaluate(given, scenario)

    def odd(leaf):
        if random.random() < 0.7:
            return leaf * random.choice(EXTREMES)
        wrong = (random.random(leaf.shape) < 0.1) & (np.arange(leaf.shape[-1]) > 0)  # starts at 0
        return np.where(wrong, random.choice(NO_NUMBERS), leaf)

    def evaluation():
        values = (*EXTREMES, *NO_NUMBERS)
        fitness, merit = map(float, random.choice(EXTREMES, 2))
        metrics = {key: float(random.choice(values)) for key in true.metrics}
        metrics = {key: x if np.isfinite(x) else None for key, x in metrics.items()}
        axes = tuple(axis._replace(motion=jax.tree.map(odd, axis.motion)) for axis in true.axes)
        path = true.contour
        if path is not None:
            path = path._replace(actual=odd(path.actual), error=odd(path.error))
        parts = [*(x for axis in axes for x in axis.motion[:3]), *([path.error] if path else [])]
        diverged = not all(np.isfinite(x).all() for x in parts)
        if diverged:
            fitness = merit = -np.inf
        return true._replace(
            fitness=fitness,
            merit=merit,
            diverged=diverged,
            metrics=metrics,
            axes=axes,
            contour=path,
        )

    def written():
        with np.errstate(all="ignore"):
            own, rivals = evaluation(), {of: evaluation()}
            write_page(scenario, Result(given, own, None), folder, rivals)
        assert (folder / "report.html").stat().st_size > 10_000
        Path(folder / "report.html").unlink()
        return "diverged" if own.diverged else "scored"

    written()  # what it compiles is not the attack's time
    for _ in range(rounds(2, 60)):
        attack.input(written)
    attack.end()
