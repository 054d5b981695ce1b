"""Tables of the page of Jee & Koren 2004 (JK04), of the runs of its batches; see ``page``."""

from experiments.shared import Batch, markdown, number, ratio

DESIGNS = {name: f"jee-koren-2004-{name.lower()}" for name in ("FLC", "AFLC", "PID")}
CONTOUR = tuple(f"cycle_{k}_rms_contour_error_BLU" for k in (1, 2, 3))
AXIAL = tuple(f"cycle_{k}_x_rms_error_BLU" for k in (1, 2, 3))
LARGEST, UNREST = "cycle_3_max_contour_error_BLU", "cycle_3_rms_command_change_unit"
MACHINE = "real machine; K_I = 8"
DEAD_ZONE = "F_c = 14, dead zone"
BEST = '"almost zero"; 1.5 the best that a control can achieve'
#: What stands in the table of readings: figure, quantity, remark of two plants, of one plant.
READ = (
    ("10", "FLC: axial RMS, cycle 3 [BLU]", "", ""),
    ("10", "AFLC: axial RMS, cycle 1 [BLU]", "learns faster here", ""),
    ("10", "AFLC: axial RMS, cycle 3 [BLU]", "", ""),
    ("10", "contour RMS, FLC / AFLC, cycle 3", "the page says what decides it", ""),
    ("11", "FLC: largest contour error after 5 s [BLU]", "", ""),
    ("11", "AFLC: largest contour error after 5 s [BLU]", BEST, BEST),
    ("12a", "AFLC: contour RMS without friction [BLU]", "K_I = 8", ""),
    ("12a", "AFLC: contour RMS with friction [BLU]", "F_c = 15, K_I = 0", ""),
    ("12b", "PID: contour RMS without friction [BLU]", "", ""),
    ("12b", "PID: contour RMS with friction [BLU]", "F_c = 15", ""),
    ("12b", "PID: largest contour error [BLU]", "F_c = 15", ""),
    ("13", "line, FLC: contour RMS after 1 s [BLU]", MACHINE, MACHINE),
    ("13", "line, AFLC: contour RMS after 1 s [BLU]", MACHINE, MACHINE),
    ("Table 4", "line, FLC: contour RMS [BLU]", MACHINE, MACHINE),
    ("Table 4", "line, AFLC: contour RMS [BLU]", MACHINE, MACHINE),
    ("Table 4", "circle, FLC: contour RMS, cycle 3 [BLU]", MACHINE, MACHINE),
    ("Table 4", "circle, AFLC: contour RMS, cycle 3 [BLU]", MACHINE, MACHINE),
    ("14", "circle, FLC: largest contour error, cycle 3 [BLU]", MACHINE, MACHINE),
    ("14", "circle, AFLC: largest contour error, cycle 3 [BLU]", MACHINE, MACHINE),
)


def readings(one: Batch, two: Batch) -> str:
    """Published figures beside both readings; of the dead zone where it changes a figure."""
    rows = {name: own.published() for name, own in (("one", one), ("two", two))}

    def simulated(where: str, figure: str, quantity: str, remark: str) -> str:
        found = [row for row in rows[where] if row[:2] == [figure, quantity] and row[5] == remark]
        return found[0][3] if found else "–"

    lines = []
    for figure, quantity, of_two, of_one in READ:
        zone = "dead zone" if "without friction" in quantity else DEAD_ZONE
        printed = next(row[2] for row in rows["one"] if row[:2] == [figure, quantity])
        lines.append([
            figure, quantity, printed,
            simulated("two", figure, quantity, of_two),
            simulated("one", figure, quantity, of_one),
            simulated("one", figure, quantity, zone),
        ])  # fmt: skip
    head = ("figure", "quantity", "published", "two plants", "one plant", "with a dead zone")
    return markdown(head, lines)


def variants(batch: Batch) -> str:
    """What each setting does to fig. 10, beside the FLC of the same plant."""
    labels = [run.settings["label"] for run in batch.runs]
    lines = []
    for label in labels[labels.index("FLC") :]:
        own = f"FLC{label.removeprefix('AFLC')}" if label.startswith("AFLC") else "FLC"
        (fixed,) = batch.values(own, CONTOUR[-1])
        *rms, largest, unrest = batch.values(label, *AXIAL, *CONTOUR, LARGEST, UNREST)
        forms = (*[".1f"] * 3, *[".2f"] * 3)
        told = [number(value, form) for value, form in zip(rms, forms, strict=True)]
        factor = fixed / rms[-1]
        lines.append([label, *told, f"{largest:.1f}", f"{unrest:.1f}", f"{factor:.1f}"])
    head = ("AFLC on the circle of fig. 10", "axial 1", "2", "3", "contour 1", "2", "3",
            "largest", "unrest", "FLC / AFLC")  # fmt: skip
    return markdown(head, lines)


def friction_sets(batch: Batch) -> str:
    """What gain and friction do to the figures that have numbers."""
    lines = [["the paper", "", "", "16.2", "3.4", "15.6", "1.5", "5.6", "4", "1.5"]]
    keys = [f"plant.parameters.{key}" for key in ("gain", "coulomb", "stiction_rise")]
    sets = dict.fromkeys(
        tuple(run.settings[key] for key in keys) for run in batch.runs if keys[1] in run.settings
    )
    for own in sets:
        machine = dict(zip(keys, own, strict=True))

        def of(
            name: str, scenario: str, *metrics: str, machine: dict[str, float] = machine
        ) -> list[float | None]:
            where = {"design": DESIGNS[name], "scenario": f"{scenario}.toml"}
            run = batch.run(**where, **machine)
            return [batch.value(run, metric) for metric in metrics]

        contour = CONTOUR[-1]
        axial, fixed = of("FLC", "circle", AXIAL[-1], contour)
        learnt, adapted = of("AFLC", "circle", AXIAL[-1], contour)
        slow = of("PID", "slow-circle", contour, LARGEST)
        slow += of("PID", "slow-circle-frictionless", contour, machine={keys[0]: own[0]})
        follows = axial is not None and axial < 100.0  # else the largest singleton is too small
        lines.append([
            *(f"{value:g}" for value in own),
            number(axial) if follows else "cannot follow",
            *map(number, (*slow, learnt)),
            number(ratio(fixed, adapted), ".2f") if follows else "–",
            *map(number, of("AFLC", "slow-circle", contour)),
        ])  # fmt: skip
    head = ("K", "F_c", "rise", "FLC axial", "PID contour", "PID largest", "PID, no friction",
            "AFLC axial", "FLC / AFLC", "AFLC, fig. 12a")  # fmt: skip
    return markdown(head, lines)


def heights(batch: Batch) -> str:
    """Integral of the error's magnitude of the steps of fig. 18, by gain, friction and height."""
    keys = ("plant.parameters.gain", "scenario", "reference.height")
    cases = sorted({tuple(run.settings[key] for key in keys) for run in batch.runs},
                   key=lambda case: (case[0], case[1] != "step.toml", case[2]))  # fmt: skip
    lines = []
    for gain, scenario, height in cases:
        own = dict(zip(keys, (gain, scenario, height), strict=True))
        runs = (batch.run(design=name, **own)
                for name in (DESIGNS["FLC"], "base-2.json", "base-3.json"))  # fmt: skip
        words = "none" if scenario == "step.toml" else "eq. 28"
        areas = (f"{run.score['iae_BLU_s']:.2f}" for run in runs)
        lines.append([f"{gain:g}", words, f"{height:g}", *areas])
    return markdown(("K", "friction", "height [BLU]", "I", "II", "III"), lines)
