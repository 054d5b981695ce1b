"""Exported C code as a program: samples on its input, commands on its output."""

import subprocess

import numpy as np

from hfc_design.formats import FORMATS, code

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


def built(compiler, design, folder, *flags, lookup=None, main=MAIN):
    """The program of a design, compiled in a new ``folder``."""
    if lookup is None:
        FORMATS["c"].write(design, folder)
    else:
        code.write_lookup(design, folder, lookup)
    name = code.c_name(design)
    (folder / "main.c").write_text(main.format(name=name))
    sources = [folder / f"{name}.c", folder / "main.c"]
    command = [compiler, "-std=c99", *WARNINGS.split(), "-O2", *flags, *sources, "-lm"]
    subprocess.run([*command, "-o", folder / "program"], check=True)
    return folder / "program"


def commands(program, samples, real=np.float64):
    """What the program answers to ``samples`` (n, signals)."""
    data = np.ascontiguousarray(samples, real).tobytes()
    found = subprocess.run([program], input=data, capture_output=True, check=True)
    assert not found.stderr
    return np.frombuffer(found.stdout, real)
