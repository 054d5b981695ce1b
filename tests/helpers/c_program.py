"""Exported C code as a program: samples on its input, commands on its output."""

import subprocess

import numpy as np

from hfc_design.formats import code
from hfc_design.formats.writing import write

WARNINGS = "-Wall -Wextra -Wpedantic -Werror -Wconversion -Wshadow -Wdouble-promotion"
MAIN = """
#include <stdio.h>
#include "{name}.h"
int main(void)
{{
    {name}_state state;
    {name}_inputs inputs;
    {name}_real command;
    {name}_init(&state);
    while (fread(&inputs, sizeof inputs, 1, stdin) == 1) {{
        command = {name}_step(&state, &inputs);
        fwrite(&command, sizeof command, 1, stdout);
    }}
    return 0;
}}
"""

#: Goes on from the numbers in the file that the first argument names, and leaves its own in the
#: second; "-" is no file. Exit code 3: it refuses the numbers, and leaves what it has then.
KEEPING = """
#include <stdio.h>
#include <string.h>
#include "{name}.h"
static {name}_real numbers[4096];
int main(int count, char **files)
{{
    {name}_state state;
    {name}_inputs inputs;
    {name}_real command;
    FILE *file;
    int refused = 0;
    {name}_init(&state);
    if (count != 3) {{
        return 2;
    }}
    if (strcmp(files[1], "-") != 0) {{
        file = fopen(files[1], "rb");
        const int size = (int)fread(numbers, sizeof numbers[0], 4096, file);
        fclose(file);
        refused = !{name}_load(&state, numbers, size);
    }}
    while (fread(&inputs, sizeof inputs, 1, stdin) == 1) {{
        command = {name}_step(&state, &inputs);
        fwrite(&command, sizeof command, 1, stdout);
    }}
    REST
    {name}_save(&state, numbers);
    if (strcmp(files[2], "-") != 0) {{
        file = fopen(files[2], "wb");
        fwrite(numbers, sizeof numbers[0], {name}_NUMBERS, file);
        fclose(file);
    }}
    return refused ? 3 : 0;
}}
"""


def built(compiler, design, folder, *flags, lookup=None, main=MAIN):
    """The program of a design, compiled in a new ``folder``."""
    files = code.sources(design) if lookup is None else code.tabulated(design, lookup)[0]
    write(folder, files)
    name = code.c_name(design)
    (folder / "main.c").write_text(main.format(name=name))
    sources = [folder / f"{name}.c", folder / "main.c"]
    command = [compiler, "-std=c99", *WARNINGS.split(), "-O2", *flags, *sources, "-lm"]
    subprocess.run([*command, "-o", folder / "program"], check=True)
    return folder / "program"


#: Of several designs; the first argument is the number of one, from 0.
ONE_OF = """
static void run_{name}(void)
{{
    {name}_state state;
    {name}_inputs inputs;
    {name}_real command;
    {name}_init(&state);
    while (fread(&inputs, sizeof inputs, 1, stdin) == 1) {{
        command = {step};
        fwrite(&command, sizeof command, 1, stdout);
    }}
}}
"""
#: The same of a whole machine that sees the path.
MACHINE = """
static void run_{name}(void)
{{
    {name}_state state;
    {name}_inputs inputs[{name}_AXES];
    {name}_path path;
    {name}_real command[{name}_AXES];
    {name}_init(&state);
    while (fread(inputs, sizeof inputs, 1, stdin) && fread(&path, sizeof path, 1, stdin)) {{
        {name}_step(&state, inputs, &path, command);
        fwrite(command, sizeof command, 1, stdout);
    }}
}}
"""


def together(designs, folder, *flags, within=None):
    """One program of all ``designs``: the name of one, its samples -> commands.

    ``within`` is a limit of each that the caller sets.
    """
    lines = ["#include <stdio.h>", "#include <stdlib.h>"]
    for k, (key, design) in enumerate(designs.items()):
        own = design.model_copy(update={"name": f"law{k}"})
        write(folder / own.name, code.sources(own))
        lines += [f'#include "{own.name}/{own.name}.h"']
        step = f"{own.name}_step(&state, &inputs)"
        if within is not None:
            step = f"{own.name}_step_within(&state, &inputs, {within[key]!r})"
        lines += [(ONE_OF if own.kind.law else MACHINE).format(name=own.name, step=step)]
    runs = ", ".join(f"run_law{k}" for k in range(len(designs)))
    lines += [f"static void (*const runs[])(void) = {{ {runs} }};"]
    lines += [
        "int main(int count, char **words)",
        "{ (void)count; runs[atoi(words[1])](); return 0; }",
    ]
    (folder / "main.c").write_text("\n".join([*lines, ""]))
    command = ["gcc", "-std=c99", *WARNINGS.split(), "-O2", *flags, *folder.rglob("*.c"), "-lm"]
    subprocess.run([*command, "-o", folder / "program"], check=True)

    def run(key, samples, real=np.float64):
        return commands(folder / "program", samples, real, [list(designs).index(key)])

    return run


def commands(program, samples, real=np.float64, arguments=()):
    """What the program answers to ``samples`` (n, signals)."""
    data = np.ascontiguousarray(samples, real).tobytes()
    command = [program, *map(str, arguments)]
    found = subprocess.run(command, input=data, capture_output=True, check=True)
    assert not found.stderr
    return np.frombuffer(found.stdout, real)
