"""A feed drive of one axis, and what commands print."""

from run_folders import hfc

SCENARIO = """
[plant]
name = "feed-drive"

[reference]
kind = "ramp"
velocity = 333.0

[simulation]
duration_s = 0.5
sample_time_s = 0.01
substeps = 4

[load]
constant = 1.0

[controller]
inputs = [{ name = "error", scale = 0.05 }, { name = "velocity", scale = 0.0005 }]
"""


def printed(*arguments):
    done = hfc(*arguments)
    assert done.exit_code == 0, done.output
    return done.stdout
