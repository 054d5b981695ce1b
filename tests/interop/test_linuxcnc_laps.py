"""LinuxCNC's streamer and sum2 add the table of laps to the commands, as laps.hal says."""

import numpy as np

from hfc_design.files.named_scenario import load_scenario
from hfc_design.report.laps import FADING, Laps
from hfc_design.simulation.laps import Filters

#: The commands of the controllers stay at 1.5 and -2.
TEST = """
loadrt threads name1=servo-thread period1=5000000
source laps.hal
loadrt sampler depth=4000 cfg=ff
addf sampler.0 servo-thread
setp laps-x.in0 1.5
setp laps-y.in0 -2
net to-x laps-x.out => sampler.0.pin.0
net to-y laps-y.out => sampler.0.pin.1
start
loadusr -w halstreamer laps.txt
loadusr -w halsampler -n {count} out.txt
"""


def test_each_sample_has_its_row_of_the_table(hal, tmp_path):
    scenario = load_scenario("milling-table-circle", {"simulation.duration_s": 1.0})
    table = np.random.default_rng(4).standard_normal((2, scenario.simulation.steps))
    none = np.zeros((1, 1))
    filters = Filters(none, none, none, (50.0, 50.0), 1)
    known = (scenario, filters, ("0",), none, none, None)
    Laps("huang-pid", *known, table, table, (table, table)).write(tmp_path)
    count = table.shape[1] + FADING + 100
    (tmp_path / "test.hal").write_text(TEST.format(count=count))
    hal.run(tmp_path, "test.hal")
    rows = np.loadtxt(tmp_path / "out.txt").T - np.array([[1.5], [-2.0]])
    begin = int(np.flatnonzero(np.abs(rows[0] - table[0, 0]) < 1e-5)[0])
    np.testing.assert_allclose(rows[:, begin : begin + table.shape[1]], table, atol=1e-6)
    np.testing.assert_allclose(rows[:, -1], 0.0, atol=1e-6)  # it has faded out
