"""Which observers are tried, what they are told apart by, and logs of other machines."""

import numpy as np
import pytest
from carts import recorded
from wording import refused

from hfc_design.identify.checks import Check, strangers
from hfc_design.identify.search import bandwidths

WAVE = np.sin(0.05 * np.arange(4000))


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        (4000, [50.0, 20.0, 5.0]),  # 4 s at 1 kHz
        (1000, [50.0, 20.0]),  # ten periods of 5 Hz are 2 s
        (200, [50.0]),
        (120, [pytest.approx(10.0 / 0.12)]),  # slower ones see less than ten periods
    ],
)
def test_observers_that_suit_a_log(steps, expected):
    assert bandwidths(recorded(WAVE[:steps], WAVE[:steps]), None) == expected


def test_observers_that_do_not_are_refused():
    told = recorded(WAVE, WAVE)
    assert bandwidths(told, 0.0) == [0.0]
    assert bandwidths(told, 200.0) == [200.0]
    for wanted in (1.0, 201.0, float("nan")):
        with refused(ValueError):
            bandwidths(told, wanted)
    with refused(ValueError):
        bandwidths(recorded(WAVE[:99], WAVE[:99]), None)


def test_a_log_that_is_replayed_far_worse_is_of_another_machine():
    logs = {name: recorded(WAVE, WAVE) for name in ("own", "like", "unlike")}
    off = {"own": 1e-3, "like": 3e-3, "unlike": 5e-3}
    checks = [Check(name, "open loop", 1.0, x, WAVE) for name, x in off.items()]
    (line,) = strangers(checks, logs)
    assert line.startswith("DOUBTFUL: unlike is replayed 5 times worse than own (open loop)")
    assert not strangers([one._replace(how=one.log) for one in checks], logs)
    lost = [checks[0], checks[1]._replace(after=float("nan"))]
    assert len(strangers(lost, logs)) == 1
