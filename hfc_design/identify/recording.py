"""A recorded motion of one axis as it is replayed."""

from typing import NamedTuple

import numpy as np

from hfc_design.core.numbers import SAME, Floats
from hfc_design.logs.signals import Signals
from plants import Drive

#: The velocity at the start is that of a cubic through so many samples.
BEGINNING = 20
#: In so many standard errors.
CLEAR = 4.0


class Recording(NamedTuple):
    """One axis, (steps,) each, in units of its drive."""

    outputs: dict[str, Floats]  # what was measured; the first is the position that is fed back
    command: Floats | None  # None: not recorded
    reference: Floats | None
    load: Floats
    added: Floats  # to the command of the controller, and within the recorded one
    usable: Floats  # 1 where the outputs count, else 0
    sample_time: float  # [s]
    rate: float  # of the position at the start
    notes: tuple[str, ...] = ()
    step: float | None = None  # of the encoder of the position, where it is seen

    @property
    def place(self) -> Floats:
        """The position that is fed back."""
        return next(iter(self.outputs.values()))

    @property
    def duration(self) -> float:
        """How long it lasts [s]."""
        return self.sample_time * len(self.load)


def recording(found: Signals, drive: Drive) -> Recording:
    """What is replayed of the signals of a ``drive``: its position, and what else was measured."""
    seen = drive.seen[0]
    place = found.values[seen]
    time = found.sample_time * np.arange(len(place[:BEGINNING]))
    (*_, rate, _), errors = np.polyfit(time, place[:BEGINNING], 3, cov=True)
    noise = max(CLEAR * np.sqrt(errors[2, 2]), SAME * np.ptp(place) / time[-1])
    if abs(rate) < noise:  # it begins at rest
        rate = 0.0
    measured = [seen, *(name for name in outputs_of(drive) if name in found.values)]
    return Recording(
        {name: found.values[name] for name in dict.fromkeys(measured)},
        found.values.get("command"),
        found.values.get("reference"),
        found.values.get("load", np.zeros_like(place)),
        found.values.get("added", np.zeros_like(place)),
        found.usable.astype(float),
        found.sample_time,
        float(rate),
        found.notes,
        found.step,
    )


def outputs_of(drive: Drive) -> list[str]:
    """Everything of a drive that can be measured."""
    fixed = drive.coefficients(drive.parameters())
    signals = drive.signals(fixed, drive.initial_state(0.0))
    pairs = {drive.seen[0]: drive.seen[1], drive.position: drive.velocity, **drive.encoders}
    return list(dict.fromkeys([*pairs, *pairs.values(), *signals]))
