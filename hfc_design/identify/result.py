"""Result of an identification, as a script receives it."""

import json

import numpy as np

from hfc_design.core.numbers import Json
from hfc_design.core.tables import line
from hfc_design.core.texts import toml_of
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.scenario import Scenario
from hfc_design.identify.identifiability import CONFIDENCE
from hfc_design.identify.outcome import Outcome
from hfc_design.identify.response import LAGS
from hfc_design.identify.scenario import scenario_text, tolerances


class Identified(Outcome):
    """Result of an identification, in words, tables and numbers."""

    def __repr__(self) -> str:
        values: dict[str, object] = {"log": self.log, "plant": self.free.drive.name}
        values |= zip(self.free.names, map(float, self.known.value), strict=True)
        return line("Identified", values)

    def _repr_html_(self) -> str:
        return "".join(one._repr_html_() for one in self.tables())

    def numbers(self) -> Json:
        """Return the content of ``identified.json``: parameters with intervals, and residuals.

        A number that is not finite is None.
        """
        known, free, fit, response = self.known, self.free, self.fit, self.response
        every = self.recording.sample_time
        parameters: Json = {
            name: {
                "value": float(known.value[k]),
                "low": float(known.low[k]),
                "high": float(known.high[k]),
                "told": known.state[k],
                "began": free.starts[name],
                "tolerance": tolerances(self)[name],
                "unit": free.unit(name),
            }
            for k, name in enumerate(free.names)
        }
        late = zip(("value", "low", "high"), (fit.late, *known.late), strict=True)
        data: Json = {
            "format": "hfc-design-identified",
            "version": 1,
            "log": self.log,
            "plant": free.drive.name,
            "confidence": CONFIDENCE,
            "parameters": parameters,
            "command_late_s": {end: float(every * samples) for end, samples in late},
            "replayed_under": fit.how,
            "position_unit": self.position_unit,
            "rms": dict(zip(self.recording.outputs, map(float, fit.rms), strict=True)),
            "checks": [
                {"log": x.log, "how": x.how, "rms_before": x.before, "rms": x.after}
                for x in self.checks
            ],
            "lag_s": every * fit.lag,
            "model_check": response
            and {
                "mode": response.mode and response.mode.model_dump(),
                "unknown_above_hz": response.unknown_above,
                "coloured": response.coloured / LAGS,
                "coherence": np.stack([response.frequency, response.coherence], axis=1).tolist(),
            },
            "untold": self.untold_lines(),
            "record_next": self.advice_line(),
            "notes": list(self.notes),
        }
        finite: Json = json.loads(json.dumps(data), parse_constant=lambda _: None)
        return finite

    def for_design(self) -> Scenario:
        """Return the scenario for a search: the identified machine with its tolerances.

        Raises:
            UserError: the parameters do not give a valid scenario.
        """
        return load_scenario(toml_of(scenario_text(self)))
