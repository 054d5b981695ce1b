"""C code of controllers of a whole machine against the runtime, sanitized; learned state in it."""

import subprocess
from math import nan

import numpy as np
import pytest
from attack import FULL
from c_program import WARNINGS
from whole_machines import DESIGNS, happenings, in_c, of_the_runtime, random_machine

from hfc_design.files.design import with_learned
from hfc_design.formats import saving
from hfc_design.formats.code import sources
from hfc_design.formats.laws import of_path
from hfc_design.formats.writing import write
from hfc_design.motion.contour import local_error

#: As KEEPING of c_program.py, of a whole machine; of what learns nothing it keeps nothing.
MAIN = """
#include <stdio.h>
#include <string.h>
#include "{name}.h"
#ifdef LEARNS
static {name}_real numbers[4096];
#endif
int main(int count, char **files)
{{
    {name}_state state;
    {name}_inputs inputs[{name}_AXES];
    {name}_real command[{name}_AXES];
    {name}_path path;
    int taken = count > 0 && files != NULL;
    {name}_init(&state);
#ifdef LEARNS
    FILE *file;
    if (count == 3 && strcmp(files[1], "-") != 0) {{
        file = fopen(files[1], "rb");
        const int size = (int)fread(numbers, sizeof numbers[0], 4096, file);
        fclose(file);
        taken = {name}_load(&state, numbers, size);
    }}
#endif
    while (fread(inputs, sizeof inputs, 1, stdin) && fread(&path, sizeof path, 1, stdin)) {{
        {name}_step(&state, inputs, &path, command);
        fwrite(command, sizeof command, 1, stdout);
    }}
#ifdef LEARNS
    if (count == 3 && strcmp(files[2], "-") != 0) {{
        {name}_save(&state, numbers);
        file = fopen(files[2], "wb");
        fwrite(numbers, sizeof numbers[0], {name}_NUMBERS, file);
        fclose(file);
    }}
#endif
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
        if name not in known:
            folder = tmp_path_factory.mktemp("c") / "c"
            write(folder, sources(DESIGNS[name]))
            main = MAIN
            if not of_path(DESIGNS[name]):
                main = main.replace("{name}_path path;", "double path[4];")
                main = main.replace("inputs, &path, command", "inputs, command")
            (folder / "main.c").write_text(main.format(name=DESIGNS[name].name))
            flags = ["-std=c99", *WARNINGS.split(), "-O2", "-ffp-contract=off", *SANITIZERS]
            flags += ["-DLEARNS"] * (name in LEARNING)
            known[name] = folder / "program"
            command = ["gcc", *flags, *sorted(folder.glob("*.c")), "-lm", "-o", known[name]]
            subprocess.run(command, check=True)
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


@pytest.mark.parametrize("name", DESIGNS)
def test_equals_the_runtime_with_faults_among_its_samples(name, built):
    design = DESIGNS[name]
    samples = happenings(design)
    told, path = samples[100]
    samples[100] = ({**told, "y": {**told["y"], "error": nan}}, path)
    if design.kind.path:
        samples[300] = (samples[300][0], samples[300][1]._replace(contour_error=np.inf))
    _, expected = of_the_runtime(design, samples)
    assert np.isnan(expected).sum() == (4 if design.kind.path else 2)
    found = commands(built(name), design, samples)
    np.testing.assert_array_equal(found, expected)
    for k, (axis, limit) in enumerate(design.limits.commands(("x", "y")).items()):
        if limit is not None:
            assert np.nanmax(np.abs(found[:, k])) == limit, axis


@pytest.mark.parametrize("seed", range(200 if FULL else 4))
def test_random_machines_command_what_the_runtime_does(seed, tmp_path):
    design = random_machine(seed)
    write(tmp_path / "c", sources(design))
    main = MAIN
    if not of_path(design):
        main = main.replace("{name}_path path;", "double path[4];")
        main = main.replace("inputs, &path, command", "inputs, command")
    (tmp_path / "c" / "main.c").write_text(main.format(name=design.name))
    files, program = sorted((tmp_path / "c").glob("*.c")), tmp_path / "program"
    command = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", *files, "-lm", "-o", program]
    subprocess.run(command, check=True)
    samples = happenings(design, 300)
    _, expected = of_the_runtime(design, samples)
    assert np.isfinite(expected).any()
    np.testing.assert_array_equal(commands(program, design, samples), expected)


def test_the_contour_error_by_the_path(tmp_path, built):
    """That which the header computes, for a control that knows its path alone."""
    built("pid")
    folder = built("pid").parent
    (folder / "error.c").write_text(
        """
#include <stdio.h>
#include "coupled.h"
int main(void)
{
    coupled_inputs axes[2];
    coupled_path path;
    while (scanf("%lf %lf %lf %lf %lf", &axes[0].error, &axes[1].error, &path.tangent[0],
               &path.tangent[1], &path.curvature) == 5) {
        printf("%.17g\\n", coupled_contour_error(axes, &path));
    }
    return 0;
}
"""
    )
    sources = [folder / file for file in ("error.c", "coupled.c")]
    subprocess.run(["gcc", "-std=c99", *sources, "-lm", "-o", tmp_path / "error"], check=True)
    random = np.random.default_rng(0)
    rows = random.normal(size=(50, 5))
    text = "\n".join(" ".join(map(repr, row)) for row in rows.tolist())
    found = subprocess.check_output([tmp_path / "error"], input=text, text=True)
    expected = [local_error(-a, -b, *others) for a, b, *others in rows.tolist()]
    assert list(map(float, found.split())) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("name", LEARNING)
def test_numbers_that_cannot_be_are_refused_and_change_nothing(name, built, tmp_path):
    """Of any of the controllers inside: none has taken its part of them then."""
    run, kept, end, fresh = built(name), *(tmp_path / own for own in ("kept", "end", "fresh"))
    commands(run, DESIGNS[name], happenings(DESIGNS[name])[:100], "-", kept)
    subprocess.run([run, "-", fresh], input=b"", check=True)
    good = np.fromfile(kept)
    odd = [good[:-1], np.append(good, 0.0), good[:0], good.copy(), good.copy()]
    odd[-2][0] = odd[-1][-1] = nan
    for numbers in odd:
        numbers.tofile(kept)
        done = subprocess.run([run, kept, end], input=b"", capture_output=True, check=False)
        assert (done.returncode, done.stderr) == (3, b"")
        assert end.read_bytes() == fresh.read_bytes()


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
    assert found == saving.taken(design, numbers[: saving.saved(design).learnt].tolist())
    ours = saving.saved(with_learned(design, found, {}))
    assert ours == saving.saved(design)  # the same sizes
    samples = happenings(design, 50)
    _, one = of_the_runtime(with_learned(design, found, {}), samples)
    _, other = of_the_runtime(controller.learned(), samples)
    np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12)
    _, fresh = of_the_runtime(design, samples)
    assert (one != fresh).any()
