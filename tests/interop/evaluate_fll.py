"""Outputs of FLL engines; runs in the environment of pyfuzzylite: JSON from stdin to stdout."""

import json
import sys

import fuzzylite as fl
import numpy as np

job = json.load(sys.stdin)
engine = fl.FllImporter().from_file(job["file"])
for name, values in job["inputs"].items():
    engine.input_variable(name).value = np.array(values)
with np.errstate(invalid="ignore", under="ignore"):
    engine.process()
json.dump(engine.output_variables[0].value.tolist(), sys.stdout)
