"""Genome of ``pid+ff``: every gain by itself."""

import numpy as np

from hfc_design.controllers.gains.genome import GainVectors
from hfc_design.controllers.linear import regulator
from hfc_design.controllers.linear.genome import LinearGenome
from hfc_design.controllers.linear.record import LEAD
from hfc_design.controllers.linear.regulator import BEHIND
from hfc_design.controllers.linear.searched import Searched
from hfc_design.core.numbers import Floats, Json

#: Cut-off of the filter, in shares of the sampling frequency: lowest, highest, where it starts.
CUT_OFF = (0.005, 1.0, 0.5)
#: The slowest integral that is searched, in shares of the one beside the slowest loop.
SLOWEST = 1e-3
#: The largest gains, in shares of those of the fastest PID.
FASTER = 10.0
#: The largest gain on a signal, in shares of that of the fastest regulator.
LARGEST = 3.0
#: Gain of a resonator, in shares of kp x its frequency, as which it acts on slower errors: lowest,
#: highest, where it starts.
RESONANT = (1e-3, 10.0, 0.3)
#: What its command may lead or lag what the nominal loop asks for, at most [rad].
ASIDE = 1.2
#: Share of the half of a range that is finer than the gain where a search starts.
FINE = 10.0


class PidGenome(LinearGenome):
    """Gains of a PID, of a filter, and on the signals of the settings.

    Of a resonator it is how large its gain is, and by what its command leads the one that makes an
    error of its frequency fade fastest.
    """

    @property
    def signals(self) -> tuple[str, ...]:
        """Those of the settings."""
        return tuple(self.settings.signals)

    def designed(self, bandwidths: Floats) -> dict[str, Floats]:
        """A PID; with signals, the regulator of all that is fed back, and an integral."""
        kp, ki, kd = regulator.pid(self.model, bandwidths)
        if not self.signals:
            return {"kp": kp, "ki": ki, "kd": kd}
        of_signals = regulator.measured(self.model, self.signals, self.drive.name)
        own = regulator.first_regulators(of_signals, kp, kd)
        return {"kp": own.pop("error"), "ki": ki, "kd": own.pop("error_rate"), **own}

    def _searched(
        self, low: dict[str, float], high: dict[str, float], start: dict[str, float]
    ) -> dict[str, Searched]:
        ends = {**low, "ki": SLOWEST * low["ki"]}
        found = {
            name: Searched(ends[name], FASTER * high[name], start[name])
            for name in ("kp", "ki", "kd")
        }
        cut_off = (share / self.every for share in CUT_OFF)
        found["derivative_hz"] = Searched(*cut_off)
        for name in self.signals:
            most = LARGEST * max(abs(high[name]), abs(start[name]))
            bend = float(np.arcsinh(FINE * most / abs(start[name])))
            found[name] = Searched(-most, most, start[name], bend)
        for name in self.settings.resonators:
            found[name] = Searched(*RESONANT)
            found[name + LEAD] = Searched(-ASIDE, ASIDE, 0.0)
        return found

    def _feedback(self, values: dict[str, Floats]) -> dict[str, Floats]:
        kept = np.exp(-2.0 * np.pi * values["derivative_hz"] * self.every)
        own = values | {"kept": kept}
        each = zip(self.settings.resonators, self.settings.load_frequencies_rad_s, strict=True)
        for name, frequency in each:
            # Where the error is answer x its share, gain x answer < 0 makes both fade.
            z = np.exp(1j * frequency * self.every)
            answer = regulator.answer(self.model, own, self.signals, z, self.every)
            turn = -z * np.exp(1j * values[name + LEAD]) * np.abs(answer) / answer
            gain = values[name] * frequency * values["kp"] * turn
            own |= {name: gain.real, name + BEHIND: gain.imag}
        return own

    def record(self, individual: GainVectors) -> Json:
        """With the filter's cut-off."""
        cut_off = float(self.values(individual)["derivative_hz"][0])
        return super().record(individual) | {"derivative_hz": cut_off}
