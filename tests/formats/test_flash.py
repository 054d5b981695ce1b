"""The folder of ``--to c``: its page, its vectors, and that ``make check`` finds what is wrong.

The vectors are recomputed with the runtime, the code is compiled by the folder's own Makefile.
"""

import csv
import re
import subprocess

import made_up
import numpy as np
import pytest
from st_program import Program
from whole_machines import DESIGNS

from hfc_design.controllers.controller import PathView
from hfc_design.files.design import builtin_designs, named_design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.formats import FORMATS, code, machine_code, saving
from hfc_design.formats.c_folder import write_lookup
from hfc_design.formats.flash.folder import with_check
from hfc_design.formats.flash.tolerance import tolerance
from hfc_design.formats.writing import write
from hfc_design.runtime import Controller, Machine

STRICT = (
    "-std=c99 -pedantic -Wall -Wextra -Werror -Wdouble-promotion -Wfloat-conversion -Wconversion"
)


#: Every built-in design that has C, axis by axis.
BUILT_IN = {
    f"{name} {axis}".strip(): part
    for name in builtin_designs()
    for axis, part in named_design(name).by_axis().items()
}
RANDOM = {
    "hierarchy": made_up.hierarchy(3),
    "adapting hierarchy": made_up.hierarchy(
        11, 5, adaptation={"k_c": 1e-2, "largest_move": 0.5, "error_scale": 3.0}
    ),
    "linear part within a limit": made_up.limited(made_up.hierarchy_on_linear(5), 300.0),
    "scheduling": made_up.scheduling(4),
    "resonators": made_up.resonating(made_up.linear("lqi", 1), 3, 2.0, 50.0, 900.0),
    "flc of 2 x 11": made_up.named(2, 2, 11),
    "aflc": made_up.fuzzy("aflc", 2),
    "aflc with options": made_up.with_options("aflc", 5),
    "soflc": made_up.fuzzy("soflc", 3),
    "network": made_up.network(4, 5),
}
ALL = BUILT_IN | RANDOM | {f"whole machine {name}": design for name, design in DESIGNS.items()}
#: One of each sort, for what need not be asked of all.
FEW = ["lin-lee-1999-table-1", "huang-soc", "huang-cross-coupled"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of a design, written once."""
    known = {}

    def of(name):
        if name not in known:
            known[name] = tmp_path_factory.mktemp("flash") / "out"
            FORMATS["c"].write(ALL[name], known[name])
        return known[name]

    return of


def checked(path, flags=STRICT):
    """Exit status and words of its ``make check``."""
    command = ["make", "-C", path, "check", f"WARNINGS={flags}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    subprocess.run(["make", "-s", "-C", path, "clean"], check=True)
    return done.returncode, done.stdout + done.stderr


def vectors(path):
    """Columns, numbers, and the notes of the file."""
    lines = (path / "check" / "vectors.csv").read_text().splitlines()
    notes = [line for line in lines if line.startswith("#")]
    names, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    return names, np.array(rows, float), "\n".join(notes)


def passes(path):
    status, told = checked(path)
    assert status == 0, told
    found = re.findall(r"(double|float): 1000 samples, of which (\d+) are compared; largest", told)
    assert [precision for precision, _ in found] == ["double", "float"]
    assert int(found[0][1]) == 1000
    assert int(found[1][1]) >= 400, told


@pytest.mark.parametrize("name", FEW)
def test_the_folder_passes_its_own_check(name, folder):
    passes(folder(name))


def test_the_folder_for_linuxcnc_passes_it_too(tmp_path):
    FORMATS["linuxcnc"].write(ALL["jee-koren-2004-flc"], tmp_path / "hal")
    passes(tmp_path / "hal")
    text = (tmp_path / "hal" / "README.md").read_text()
    assert "make check" in text
    assert "The command is not limited" in text
    assert "1 BLU is 0.01 mm" in text
    assert "source: Jee & Koren 2004" in text


@pytest.mark.slow
def test_one_make_checks_every_axis(tmp_path):
    FORMATS["c"].write(named_design("lin-gai-2009-pid"), tmp_path / "c")
    status, told = checked(tmp_path / "c")
    assert (status, told.count(": ok\n")) == (0, 10), told
    text = (tmp_path / "c" / "README.md").read_text()
    assert re.findall(r"- \[(\w)\]\((\w)/README.md\)", text) == [(x, x) for x in "xyzac"]
    source = tmp_path / "c" / "z" / "lin_gai_2009_pid_z.c"
    source.write_text(source.read_text().replace("inputs->error", "2 * inputs->error"))
    status, told = checked(tmp_path / "c")
    assert status != 0
    assert "FAILED" in told


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in ALL if name not in FEW])
def test_every_folder_passes_its_own_check(name, folder):
    passes(folder(name))


def of_the_runtime(design, names, numbers):
    """The commands for the inputs in the columns."""
    axes = [name.removesuffix("command").strip(".") for name in names if name.endswith("command")]
    controller, found = Controller(design) if axes == [""] else Machine(design, tuple(axes)), []
    for row in numbers.tolist():
        told = {axis: {} for axis in [*axes, "path"]}
        for name, x in zip(names, row, strict=True):
            axis, _, signal = name.rpartition(".")
            told[axis if axis in told else axes[0]][signal] = x
        if row[0]:
            controller.reset()
        if axes == [""]:
            found.append([controller.step(told[""])])
            continue
        way = told.pop("path")
        tangent = (way.pop("tangent_x"), way.pop("tangent_y")) if way else None
        found.append(
            list(controller.step(told, PathView(tangent, **way) if way else None).values())
        )
    return found


NEEDS = {
    "lin-lee-1999-table-1": {"expf"},
    "huang-neural": {"tanhf"},
    "huang-cross-coupled": {"sqrtf"},
    "jee-koren-2004-aflc": set(),
}


def outside(folder):
    """What the sources of a folder, in float, need of a library, and memory that they take."""
    files = sorted(path.name for path in folder.glob("*.c"))
    flags = ("-std=c99", "-O1", "-DHFC_FLOAT", "-ffreestanding", "-fno-pic", "-c")
    subprocess.run(["gcc", *flags, *files], cwd=folder, check=True)
    objects = [file.replace(".c", ".o") for file in files]
    told = subprocess.check_output(["nm", *objects], cwd=folder, text=True)
    symbols = [line.split()[-2:] for line in told.splitlines() if " " in line]
    own = {name for kind, name in symbols if kind == "T"}
    assert {kind for kind, _ in symbols} <= {"T", "t", "r", "U"}  # code and constant tables
    # A compiler may copy and clear memory with these wherever it likes.
    return {name for kind, name in symbols if kind == "U"} - own - {"memcpy", "memset"}


@pytest.mark.parametrize("name", NEEDS)
def test_float_needs_one_function_at_most_and_no_heap(name, tmp_path):
    write(tmp_path / "c", machine_code.sources(ALL[name]))
    assert outside(tmp_path / "c") == NEEDS[name]


def test_a_lookup_in_float_needs_nothing(tmp_path):
    write(tmp_path / "c", code.tabulated(ALL["lin-lee-1999-table-1"], 9)[0])
    assert outside(tmp_path / "c") == set()


@pytest.mark.parametrize("name", FEW)
def test_the_vectors_are_those_of_the_runtime(name, folder):
    names, numbers, _ = vectors(folder(name))
    expected = of_the_runtime(ALL[name], names, numbers)
    commands = [k for k, x in enumerate(names) if x.endswith("command")]
    np.testing.assert_array_equal(numbers[:, commands], expected)


def test_single_precision_is_compared_until_a_decision_is_close():
    """By hand: the last 50 samples of a command of 100 are twice as far off in one of the tries."""
    commands = np.full((1000, 1), 100.0)
    near = commands + 2e-5
    far = commands + 1e-4 * (np.arange(1000) >= 970)[:, None]
    found = tolerance(commands, [near, commands], [far])
    assert found.double == 1e-10
    assert found.single == pytest.approx(8e-5, rel=1e-9)
    assert all(found.alike)  # what is a few times as far off has no other reason
    far[970:] += 0.01
    found = tolerance(commands, [near, commands], [far])
    assert [k for k, alike in enumerate(found.alike) if not alike] == list(range(970, 1000))
    far[400] += 0.01  # all is forgotten before sample 550
    found = tolerance(commands, [near, commands], [far])
    assert sum(found.alike) == 1000 - 150 - 30
    exact = tolerance(commands, [commands], [commands])
    assert exact.single == pytest.approx(2.0**-21 * 100.0)


def test_the_vectors_go_beyond_the_ends_of_the_universe(folder):
    names, numbers, _ = vectors(folder("lin-lee-1999-table-1"))
    record = ALL["lin-lee-1999-table-1"].controller
    for item in record.inputs:
        column = numbers[:, names.index(item.name.removeprefix("previous_"))] * item.scale
        assert column.min() < -1.2
        assert column.max() > 1.2
        assert ((np.abs(column) < 0.1) & (column != 0)).sum() > 30


@pytest.mark.parametrize("name", ["jee-koren-2004-flc", "jee-koren-1995-fit-flc"])
def test_every_rule_of_a_table_fires(name, folder):
    """Judged by centres: error and its change come nearer to those of every rule than the next."""
    names, numbers, _ = vectors(folder(name))
    record = ALL[name].controller
    error = numbers[:, names.index("error")]
    places = []
    for terms, values in (
        (record.error_terms, error),
        (record.error_change_terms, np.diff(error, prepend=0.0)),
    ):
        centres = np.array([term.centre for term in terms])
        places.append(np.abs(values[:, None] - centres).argmin(axis=1))
    assert len(set(zip(*places, strict=True))) == len(record.error_terms) * len(
        record.error_change_terms
    )


#: Where numbers of a table stand in the C of a design.
TABLES = {
    "jee-koren-2004-flc": "real table[ERROR_TERMS][CHANGE_TERMS] = {",
    "lin-lee-1999-table-1": "real table_3[RULES] = {",
    "jee-koren-2004-aflc": "real start_table[ERROR_TERMS][CHANGE_TERMS] = {",
    "huang-neural": "real start_output[UNITS + 1] = {",
}


def mutants(source, mark, factor=1.01):
    """The C with each number of a table 1 % larger, one after the other."""
    begin = source.index(mark) + len(mark)
    for found in re.finditer(r"R\(([^)]+)\)", source[begin : source.index("};", begin)]):
        if value := float(found[1]):
            first, last = begin + found.start(), begin + found.end()
            yield f"{source[:first]}R({factor * value!r}){source[last:]}"


def found_wrong(folder, source, precision):
    """Whether a check ends with an error for another ``source`` of the folder."""
    place, target = next(folder.glob("*.c")), f"check/{precision}"
    kept = place.read_text()
    place.write_text(source)
    try:
        subprocess.run(["make", "-s", "-B", "-C", folder, target], check=True)
        command = [folder / target, folder / "check" / "vectors.csv"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.stdout.endswith(": ok\n" if done.returncode == 0 else ": FAILED\n")
        return done.returncode == 1
    finally:
        place.write_text(kept)
        subprocess.run(["make", "-s", "-C", folder, "clean"], check=True)


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["jee-koren-2004-flc", "lin-lee-1999-table-1"])
def test_a_number_that_is_off_by_one_per_cent_is_found(name, precision, folder):
    path = folder(name)
    source = next(path.glob("*.c")).read_text()
    last = list(mutants(source, TABLES[name]))[-1]  # the rule of a corner
    assert found_wrong(path, last, precision)
    assert not found_wrong(path, source, precision)


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
def test_every_number_of_a_table_that_is_off_by_one_per_cent_is_found(name, folder):
    """Up or down: an adaptation holds a table to its stable range, whatever it starts from."""
    path = folder(name)
    source = next(path.glob("*.c")).read_text()
    pairs = zip(*(mutants(source, TABLES[name], x) for x in (1.01, 0.99)), strict=True)
    found = [any(found_wrong(path, one, "double") for one in pair) for pair in pairs]
    assert len(found) >= 10
    assert all(found), found


SCHEDULING = made_up.limited(made_up.scheduling(5), 60.0)


@pytest.mark.parametrize("made", [None, pytest.param(SCHEDULING, marks=pytest.mark.slow)])
def test_a_lookup_passes_too_and_needs_no_library(made, tmp_path):
    write_lookup(made or ALL["lin-lee-1999-table-1"], tmp_path / "c", 33)
    passes(tmp_path / "c")
    assert "LDLIBS =\n" in (tmp_path / "c" / "Makefile").read_text()
    assert "tabulated at 33 values" in vectors(tmp_path / "c")[2]
    assert "tabulated at 33 values" in (tmp_path / "c" / "README.md").read_text()


@pytest.mark.parametrize("name", FEW)
def test_the_page_names_every_input_with_its_unit(name, folder):
    text = (folder(name) / "README.md").read_text()
    for signal, unit in code.signals(ALL[name]).items():
        assert unit
        assert re.search(rf"\| `{signal}` \| in \| {re.escape(unit)} \| \w", text), signal
    assert re.search(r"\| `command` \| out \| \w+ \| \w", text)


@pytest.mark.slow
def test_axes_that_differ_have_units_of_their_own():
    record = ALL["lin-gai-2009-fuzzy-sliding-compensated"]
    text = with_check(record, machine_code.sources(record))["README.md"]
    assert "| x, y, z | `error` | in | mm | reference less position |" in text
    assert "| a, c | `error_rate` | in | deg/s |" in text


def page(design):
    return with_check(design, machine_code.sources(design))["README.md"]


def sensed(name, **sensors):
    """A built-in design whose scenario has these sensors."""
    design = named_design(name)
    scenario = load_scenario(design.provenance["scenario"]).model_dump(
        mode="json", exclude_none=True
    )
    scenario["sensors"] = sensors
    return design.model_copy(update={"provenance": {"scenario": scenario}})


def test_the_page_says_how_velocities_were_formed():
    text = page(
        sensed("pd-only", velocity="encoder", difference_samples=3, encoder_resolution=1e-5)
    )
    assert "velocity = (position[0] - position[3]) / 0.003;" in text
    assert "read in steps of 1e-05 rad" in text
    text = page(sensed("pd-only", velocity="observer", observer_hz=100.0))
    assert "The velocities in `error_rate` come from a tracking observer of 100.0 Hz" in text
    pole = np.exp(-2.0 * np.pi * 100.0 * 0.001)  # docs/sensors.md
    alpha, gain = map(float, re.findall(r"= (?:expected|velocity) \+ ([\d.]+) \* off;", text))
    assert alpha == pytest.approx(1.0 - pole**2, rel=1e-12)
    assert gain == pytest.approx((1.0 - pole) ** 2 / 0.001, rel=1e-12)


def test_the_page_says_which_signals_are_made_of_velocities(folder):
    text = (folder("lin-lee-1999-table-1") / "README.md").read_text()
    assert "velocities in `error_rate`, `deflection_rate`, `spindle_velocity` were the true" in text
    assert "ideal tachometer" in text


def test_the_page_says_what_is_filtered_and_limited():
    filtered = made_up.limited(made_up.linear("pid+ff", 4), 40.0)
    own = filtered.controller.model_copy(update={"derivative_hz": 90.0})
    text = page(filtered.model_copy(update={"controller": own}))
    assert "`error_rate` passes a low-pass of the first order at 90.0 Hz" in text
    assert "The command keeps to 40.0 V of either sign" in text
    assert "The command is not limited" in page(named_design("pd-only"))


def test_nothing_that_a_user_wrote_is_markup_or_code():
    evil = "<b>*/ #include [x](y) `"
    design = named_design("pd-only")
    found = with_check(
        design.model_copy(
            update={"name": evil, "score": {evil: 1.0}, "provenance": {"source": evil}}
        ),
        machine_code.sources(design.model_copy(update={"name": evil})),
    )
    assert "<b>" not in found["README.md"].replace("\\<b\\>", "")
    assert "[x](y)" not in found["README.md"]
    for text in (found["Makefile"], found["check"]["check.c"], found["check"]["vectors.csv"]):
        assert "<b>" not in text
        assert "#include [" not in text


@pytest.mark.parametrize(
    "name", ["pd-only", "jee-koren-2004-aflc", *map("whole machine {}".format, DESIGNS)]
)
def test_the_size_of_a_state_is_that_of_the_compiler(name, tmp_path):
    design = ALL[name]
    write(tmp_path / "c", machine_code.sources(design))
    own = code.c_name(design)
    lines = f'#include <stdio.h>\n#include "{own}.h"\n'
    lines += f'int main(void) {{ printf("%d", (int)sizeof({own}_state)); return 0; }}\n'
    (tmp_path / "c" / "size.c").write_text(lines)
    for k, flags in enumerate(((), ("-DHFC_FLOAT",))):
        command = ["gcc", *flags, tmp_path / "c" / "size.c", "-o", tmp_path / "size"]
        subprocess.run(command, check=True)
        assert int(subprocess.check_output([tmp_path / "size"])) == saving.size(design)[k]


ST = ["pd-only", "jee-koren-2004-flc"]
SLOW_ST = [name for name, design in ALL.items() if design.kind.st and name not in ST]


def runs_in_a_plc(design, folder):
    """Whether the program of the vectors ends well, and does not with another expectation."""
    FORMATS["st"].write(design, folder)
    (block,) = (path.read_text() for path in folder.glob("*.st"))
    text = (folder / "check" / "check.st").read_text()
    program = Program(text, block)
    for k in range(1000):
        assert not program.values["done"], k
        program.cycle()
    assert program.values["done"]
    assert program.values["ok"], program.values["largest_off"]
    assert program.values["faults"] == 0
    names, numbers, _ = vectors(folder)
    for column in range(2, len(names) - 1):
        assert program.values[f"given_{names[column]}"] == numbers[:, column].tolist()
    program.values |= {"k": 999, "tolerance": 0.0}
    program.values["expected"][999] += 1.0
    program.cycle()
    assert not program.values["ok"]
    text = (folder / "README.md").read_text()
    assert f"`{program.block}`" in text


@pytest.mark.parametrize("name", ST)
def test_a_plc_runs_the_vectors(name, tmp_path):
    runs_in_a_plc(ALL[name], tmp_path / "st")


@pytest.mark.slow
@pytest.mark.parametrize("name", SLOW_ST)
def test_a_plc_runs_all_vectors(name, tmp_path):
    runs_in_a_plc(ALL[name], tmp_path / "st")


def test_a_project_for_a_plc_has_the_same(tmp_path):
    for target in ("st", "plcopen"):
        FORMATS[target].write(ALL["jee-koren-2004-flc"], tmp_path / target)
    for file in ("check/check.st", "check/vectors.csv"):
        assert (tmp_path / "st" / file).read_text() == (tmp_path / "plcopen" / file).read_text()
    names = {path.name for path in (tmp_path / "plcopen").iterdir()}
    assert names == {"README.md", "check", "jee_koren_2004_flc.xml"}
