"""By FMPy, in its own environment: FMUs under tables of inputs, and what comes out.

Each argument is a job, as in FMU,INPUTS.npy,OUTPUTS.npy,EVERY; "-" ends it where FMPy is to compile
the sources itself. A column of INPUTS is an input of the FMU in the order of its description, a row
a sample; OUTPUTS has a column for each output, after each sample.
"""

import shutil
import sys
from pathlib import Path

import numpy as np
from fmpy import extract, platform, platform_tuple, read_model_description, simulate_fmu
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu


def compiled(folder):
    """The unpacked FMU with a binary that FMPy's own build has made, and no other."""
    shutil.rmtree(Path(folder) / "binaries", ignore_errors=True)
    build_platform_binary(folder, cmake_options={})
    version = read_model_description(folder).fmiVersion
    own = platform if version == "2.0" else platform_tuple
    assert list((Path(folder) / "binaries" / own).iterdir())


def run(fmu, inputs, outputs, every, sources=""):
    assert not (problems := validate_fmu(fmu)), problems
    described = read_model_description(fmu)
    names = {
        causality: [x.name for x in described.modelVariables if x.causality == causality]
        for causality in ("input", "output")
    }
    table, every = np.load(inputs), float(every)
    columns = [np.arange(len(table)) * every, *table.T]
    fields = [(name, np.float64) for name in ["time", *names["input"]]]
    given = np.array(list(zip(*columns, strict=True)), fields)
    where = extract(fmu)
    try:
        if sources:
            compiled(where)
        found = simulate_fmu(
            where,
            stop_time=len(table) * every,
            step_size=every,
            output_interval=every,
            input=given,
            output=names["output"],
        )
    finally:
        shutil.rmtree(where, ignore_errors=True)
    np.save(outputs, np.stack([found[name] for name in names["output"]], axis=1)[1:])


for job in sys.argv[1:]:
    run(*job.split(","))
