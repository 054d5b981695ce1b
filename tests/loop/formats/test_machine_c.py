"""C code of controllers of a whole machine against the runtime, sanitized; learned state in it."""

import subprocess

import numpy as np
import pytest
from c_program import WARNINGS
from whole_machines import (
    DESIGNS,
    happenings,
    in_c,
    of_the_runtime,
)

from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.files.learning import with_learned
from hfc_design.formats import FORMATS, saving
from hfc_design.formats.machine_code import sources
from hfc_design.formats.writing import write

MAIN = """
#include <stdio.h>
#include <string.h>
#include "{name}.h"
static {name}_real numbers[4096];
int main(int count, char **files)
{{
    {name}_state state;
    {name}_inputs inputs[{name}_AXES];
    {name}_real command[{name}_AXES];
    PATH
    FILE *file;
    int taken = 1;
    {name}_init(&state);
    if (count == 3 && strcmp(files[1], "-") != 0) {{
        file = fopen(files[1], "rb");
        const int size = (int)fread(numbers, sizeof numbers[0], 4096, file);
        fclose(file);
        taken = LOAD(&state, numbers, size);
    }}
    while (fread(inputs, sizeof inputs, 1, stdin) == 1 && READ) {{
        {name}_step(&state, inputs, GIVEcommand);
        fwrite(command, sizeof command, 1, stdout);
    }}
    if (count == 3 && strcmp(files[2], "-") != 0) {{
        SAVE(&state, numbers);
        file = fopen(files[2], "wb");
        fwrite(numbers, sizeof numbers[0], SIZE, file);
        fclose(file);
    }}
    return taken ? 0 : 3;
}}
"""
SANITIZERS = "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"
LEARNING = [name for name, design in DESIGNS.items() if saving.learns(design)]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The program of a design, compiled once, with whatever looks at it while it runs."""
    known = {}

    def of(name):
        if name in known:
            return known[name]
        folder = tmp_path_factory.mktemp("c") / "c"
        write(folder, sources(DESIGNS[name]))
        own = DESIGNS[name].name
        sees = f"{own}_path" in (folder / f"{own}.h").read_text()
        main = MAIN.replace("PATH", "{name}_path path;" if sees else "double path[4];")
        main = main.replace("READ", "fread(&path, sizeof path, 1, stdin) == 1")
        main = main.replace("GIVE", "&path, " if sees else "")
        words = {"SAVE": "{name}_save", "LOAD": "{name}_load", "SIZE": "{name}_NUMBERS"}
        none = {"SAVE": "(void)", "LOAD": "(void)", "SIZE": "0"}
        for word, by in (words if name in LEARNING else none).items():
            main = main.replace(word, by)
        if name not in LEARNING:
            main = main.replace("(void)(&state, numbers, size)", "size == 0")
            main = main.replace("(void)(&state, numbers);", "")
        (folder / "main.c").write_text(main.format(name=own))
        flags = ["-std=c99", *WARNINGS.split(), "-O2", *SANITIZERS]
        command = ["gcc", *flags, *sorted(folder.glob("*.c")), "-lm", "-o", folder / "program"]
        subprocess.run(command, check=True)
        known[name] = folder / "program"
        return known[name]

    return of


def commands(program, design, samples, *files):
    done = subprocess.run(
        [program, *map(str, files)],
        input=in_c(design, samples).tobytes(),
        capture_output=True,
        check=True,
    )
    assert not done.stderr
    return np.frombuffer(done.stdout).reshape(-1, 2)


@pytest.mark.parametrize("name", LEARNING)
def test_half_a_motion_and_the_rest_in_another_process(name, built, tmp_path):
    """Bit for bit; and back on the PC what the runtime has learnt."""
    design, run = DESIGNS[name], built(name)
    samples, kept, end = happenings(design), tmp_path / "kept", tmp_path / "end"
    whole = commands(run, design, samples, "-", tmp_path / "whole")
    first = commands(run, design, samples[:290], "-", kept)
    rest = commands(run, design, samples[290:], kept, end)
    np.testing.assert_array_equal(np.concatenate([first, rest]), whole)
    assert end.read_bytes() == (tmp_path / "whole").read_bytes()
    controller, _ = of_the_runtime(design, samples)
    numbers = np.fromfile(end)
    found = saving.taken(design, numbers.tolist())
    assert found == saving.taken(design, numbers[: saving.values(design)["learnt"]].tolist())
    ours = saving.values(with_learned(design, found, {}))
    assert ours == saving.values(design)  # the same sizes
    samples = happenings(design, 50)
    _, one = of_the_runtime(with_learned(design, found, {}), samples)
    _, other = of_the_runtime(controller.learned(), samples)
    np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12)
    _, fresh = of_the_runtime(design, samples)
    assert (one != fresh).any()


@pytest.mark.parametrize("axis", ["error", "while"])
def test_an_axis_that_c_takes_for_something_else_is_refused(axis, tmp_path):
    data = DESIGNS["pid"].model_dump(mode="json")
    data["plant"]["axes"] = {axis: {}, "y": {}}
    with pytest.raises(UserError, match=f"an axis named {axis} cannot be one in C"):
        FORMATS["c"].write(Design.model_validate(data), tmp_path / "c")
