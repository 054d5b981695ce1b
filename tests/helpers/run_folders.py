"""Folders of finished runs, as far as a report of many reads them."""

import csv
import json

from click.testing import CliRunner

from hfc_design.cli import main

HOSTILE = '<script>alert("1")</script> & $x^$ \x01 Ω 漢'


def hfc(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def ran(*arguments):
    """What a command prints that does what it is asked."""
    done = hfc(*arguments)
    assert done.exit_code == 0, done.output
    return done.stdout


def table(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def reported(out, *options):
    """What the terminal says of a report, and its page, each as one line."""
    done = hfc("report", out, *options)
    assert done.exit_code == 0, done.output
    page = (out / "report.html").read_text() if (out / "report.html").exists() else ""
    return " ".join(done.stdout.split()), " ".join(page.split())


def with_score(folder, **changes):
    """Let the design of a finished run say something else of its score."""
    path = folder / "design.json"
    design = json.loads(path.read_text())
    design["score"] |= changes
    path.write_text(json.dumps(design))


def run_folder(path, fitness, generations=3):
    """What a finished run leaves behind, as far as a summary reads it."""
    path.mkdir(parents=True)
    score = {"scenario": "s", "fitness": fitness, "rms_error_rad": 1e-3, "settling_time_s": None}
    (path / "design.json").write_text(json.dumps({"format": "x", "score": score}))
    rows = [f"{k},{fitness * (k + 1) / generations!r},1.0,0,5" for k in range(generations)]
    (path / "history.csv").write_text(
        "generation,best,median,diverged,structures\n" + "\n".join(rows) + "\n"
    )


def searched(path, fitness, title="fitness"):
    """A run folder with a configuration, whose design says what it was ranked by."""
    run_folder(path, fitness)
    (path / "config.toml").write_text(f'name = "mine"\n[run]\nseed = {int(fitness)}\n')
    design = json.loads((path / "design.json").read_text())
    design["score"] |= {"merit": fitness, "judged_by": title}
    (path / "design.json").write_text(json.dumps(design))
    return path


def batch_folder(out, groups, **run):
    """A batch of finished runs: (settings of a group, fitness of each of its seeds)."""
    plan = {}
    for settings, fitness in groups:
        for seed, value in enumerate(fitness):
            name = f"{len(plan):016x}"
            plan[name] = {**settings, "run.seed": seed}
            run_folder(out / name, value, **run)
    (out / "batch.json").write_text(json.dumps({"cells": plan}))
    return list(plan)


PRESETS = [
    ({"scenario": "a", "search.preset": "race"}, [10.0, 14.0, 11.0, 13.0, 12.0]),
    ({"scenario": "a", "search.preset": "lin-lee-1999"}, [1.0, 2.0, 12.5, 4.0, 3.0]),
    ({"scenario": "a", "search.preset": "third"}, [5.0, 5.0, 6.0, 0.0, 5.0]),
    ({"scenario": "b", "search.preset": "race"}, [0.0, 0.0, 0.0]),
]


def with_answer(folder, verdict, share, **more):
    """Let a finished run say whether its design can be used."""
    told = {"usable": verdict == "yes", "answer": f"{verdict}: {share}", "share": share}
    (folder / "usable.json").write_text(json.dumps(told | {"verdict": verdict} | more))
