"""The folder of an experiment: its page, and the experiment as CSV, G-code, C and for HAL."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hfc_design.core.tables import Table
from hfc_design.core.wording import percent, three_digits
from hfc_design.files.machine import Axis
from hfc_design.formats import sampled
from hfc_design.formats.writing import Content
from hfc_design.formats.writing import write as write_files
from hfc_design.identify.experiment import Experiment
from hfc_design.plotting.curves import thinned
from hfc_design.plotting.figure import OTHER, OWN, finish, framed
from hfc_design.plotting.files import small_address
from hfc_design.report import REPORT, rendered

#: Period of the points of a sine in G-code [s].
POINTS = 0.02


def write(made: Experiment, axis: Axis, known: Mapping[str, str], path: Path, command: str) -> None:
    """Write the folder of an experiment.

    ``known`` has the name of the ``plant``, and that of the ``scenario`` or ""; ``command`` is the
    command line that made the experiment.

    Raises:
        RunError: the folder cannot be written.
    """
    parts, limits, errors = tables(made)
    page = rendered(
        "experiment.html.j2",
        f"experiment for {known['plant']}",
        small_address,
        made=made,
        **known,
        units=made.units,
        gcode="mm" if axis.length else "degrees",
        drawn=drawn(made),
        command=command,
        segments=parts,
        limits=limits,
        errors=errors,
    )
    error, volt = made.units["error"], made.units["command"]
    columns = {"reference": (made.reference, error), "added": (made.added, volt)}
    # Without an added signal it is a table that a scenario can name as its reference.
    shown = columns if made.added.any() else {"reference": columns["reference"]}
    files: dict[str, Content] = {
        "experiment.csv": sampled.csv(made.time, shown),
        "experiment.h": sampled.c_header("experiment", made.sample_time, columns),
        "experiment.ngc": "\n".join(_gcode(made, axis)) + "\n",
        "experiment.txt": sampled.streamed(columns),
        "experiment.hal": HAL.format(period=round(1e9 * made.sample_time), rows=len(made.time) + 1),
        REPORT: page.html,
    }
    write_files(path, files)


def tables(made: Experiment) -> list[Table]:
    """Return the tables of the segments, of the limits, and of the expected errors."""
    rows, begin = [], 0.0
    for one in made.segments:
        rows.append([f"{begin:.3g} s", one.told(made.units)])
        begin += len(one.reference) * made.sample_time
    unit = made.units["error"]
    units = (unit, f"{unit}/s", f"{unit}/s²", made.units["command"])
    limits = [
        [f"{name} [{unit}]", three_digits(most), percent(made.reached[name])]
        for (name, most), unit in zip(made.limits._asdict().items(), units, strict=True)
    ]
    errors = [[name, percent(one), percent(two)] for name, (one, two) in made.errors.items()]
    about = "Limits, and the largest share of them on any machine (acceleration: of the reference)."
    known = (
        "Standard error of each parameter from a log of this experiment, and of the scenario's "
        "motion for as long, if the model is right: only encoder steps and noise count."
    )
    return [
        Table("The segments, each from rest to rest.", ("from", "motion"), rows),
        Table(about, ("limit", "value", "used"), limits),
        Table(known, ("parameter", "scenario's motion", "experiment"), errors),
    ]


def drawn(made: Experiment) -> Figure:
    """Draw reference and added signal against time."""
    panels = 1 + bool(made.added.any())
    figure = framed(0.6 + 1.9 * panels, top=0.1)
    first, *others = np.atleast_1d(figure.subplots(panels, sharex=True))
    first.plot(*thinned(made.time, made.reference), color=OWN, lw=1.0)
    finish(first, f"reference [{made.units['error']}]", "" if others else "time [s]")
    for axes in others:
        axes.plot(*thinned(made.time, made.added), color=OTHER, lw=0.6)
        finish(axes, f"added [{made.units['command']}]", "time [s]")
    return figure


def _gcode(made: Experiment, axis: Axis) -> Iterator[str]:
    """Yield the program: moves with their feeds, all else as points in inverse time (G93)."""
    size = axis.length or 180.0 / np.pi
    other = "X" if axis.length else "C"
    letter = axis.name.upper() if axis.name.upper() in tuple("XYZABC") else other
    unit = "mm" if axis.length else "deg"
    yield f"(Experiment of hfc-design, {unit}, from the middle of the travel)"
    yield "G21 G91.1 G90 G94 G64 P0"
    step = max(round(POINTS / made.sample_time), 1)
    for one in made.segments:
        yield f"({one.told(made.units).replace('(', '[').replace(')', ']')})"
        takes = len(one.reference) * made.sample_time
        if one.moves:
            for place, speed in one.moves:
                yield f"G1 {letter}{size * place:.6f} F{60.0 * size * speed:.6g}"
        else:
            yield "G93"
            places = size * one.reference[step - 1 :: step]
            for place in places:
                yield f"G1 {letter}{place:.6f} F{60.0 / (step * made.sample_time):.6g}"
            yield "G94"
            takes = 0.2
        yield f"G4 P{min(takes, 0.2):.3g}"
    yield "M2"


HAL = """# Experiment of hfc-design for LinuxCNC: streams the reference, records the axis.
#   halrun -f experiment.hal, or source it before the lines of the servo thread of a machine;
#   halstreamer < experiment.txt     then     halsampler -t > log.txt
# A row of experiment.txt is a sample: reference, signal added to the command. Replace NAMES below.
#loadrt threads name1=servo-thread period1={period}
loadrt streamer depth={rows} cfg=ff
loadrt sampler depth={rows} cfg=ffff
addf streamer.0 servo-thread
addf sampler.0 servo-thread
net experiment-reference <= streamer.0.pin.0
net experiment-added <= streamer.0.pin.1
#net experiment-reference => PID.command
#net experiment-added => SUM.in1
net experiment-reference => sampler.0.pin.0
#net POSITION-FEEDBACK => sampler.0.pin.1
#net COMMAND => sampler.0.pin.2
net experiment-added => sampler.0.pin.3
"""
