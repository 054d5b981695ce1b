"""Everything that a log tells of a machine, for a script."""

import json

import numpy as np

from hfc_design.core.numbers import Json
from hfc_design.core.shown import line, table
from hfc_design.core.texts import toml_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.identifiability import CONFIDENCE, GIVEN
from hfc_design.identify.outcome import Outcome
from hfc_design.identify.response import LAGS
from hfc_design.identify.scenario import scenario_text, tolerances
from hfc_design.identify.tables import advice_line, check_rows, parameter_rows, untold_lines


class Identified(Outcome):
    """Everything that a log tells, in words, tables and numbers."""

    def __repr__(self) -> str:
        told: dict[str, object] = {"log": self.log, "plant": self.free.drive.name}
        told |= zip(self.free.names, map(float, self.known.value), strict=True)
        return line("Identified", told)

    def _repr_html_(self) -> str:
        rows: dict[str, object] = {}
        for name, unit, _, value, low, high, state in parameter_rows(self):
            how = f"{low} to {high}" if state in ("yes", GIVEN) else state
            rows[f"{name} [{unit or 1}]"] = f"{value} ({how})"
        for log, how, before, after in check_rows(self):
            rows[f"{log}, {how}"] = f"{after} off (rms), {before} before"
        return table(f"{self.free.drive.name} by {self.log}", rows)

    def numbers(self) -> Json:
        """What ``identified.json`` holds: each parameter with its interval, what is left.

        A number that is none is None.
        """
        known, free = self.known, self.free
        parameters: Json = {
            name: {
                "value": float(known.value[k]),
                "low": float(known.low[k]),
                "high": float(known.high[k]),
                "told": self.states[k],
                "began": free.starts[name],
                "tolerance": tolerances(self)[name],
                "unit": free.unit(name),
            }
            for k, name in enumerate(free.names)
        }
        late = self.told.sample_time * np.array([self.found.fit.late, *known.late])
        own = self.response
        check = own and {
            "mode": own.mode and own.mode.model_dump(),
            "unknown_above_hz": own.unknown_above,
            "coloured": own.coloured / LAGS,
            "coherence": np.stack([own.frequency, own.coherence], axis=1).tolist(),
        }
        data: Json = {
            "format": "hfc-design-identified",
            "version": 1,
            "log": self.log,
            "plant": free.drive.name,
            "confidence": CONFIDENCE,
            "parameters": parameters,
            "command_late_s": dict(zip(("value", "low", "high"), map(float, late), strict=True)),
            "replayed_under": self.found.how,
            "position_unit": self.position_unit,
            "rms": dict(zip(self.told.outputs, map(float, self.found.fit.rms), strict=True)),
            "checks": [
                {"log": one.log, "how": one.how, "rms_before": one.before, "rms": one.after}
                for one in self.checks
            ],
            "lag_s": self.told.sample_time * self.found.fit.lag,
            "model_check": check,
            "untold": untold_lines(self),
            "record_next": advice_line(self),
            "notes": list(self.notes),
        }
        told: Json = json.loads(json.dumps(data), parse_constant=lambda _: None)
        return told

    def for_design(self) -> Scenario:
        """The scenario for a search: the machine as it was found, within its tolerances.

        Raises:
            UserError: it is no scenario with these parameters.
        """
        return load_scenario(toml_of(scenario_text(self)))
