"""What a log tells, in numbers."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hfc_design.core.numbers import Json
from hfc_design.identify.aim import tolerances
from hfc_design.identify.certainty import CONFIDENCE
from hfc_design.identify.response import LAGS, Response
from hfc_design.identify.words import advice_line, untold_lines

if TYPE_CHECKING:
    from hfc_design.identify.result import Identified


def numbers(found: "Identified") -> Json:
    """What ``found`` tells as plain data; a number that is none is None."""
    known, free = found.known, found.free
    parameters: Json = {
        name: {
            "value": float(known.value[k]),
            "low": float(known.low[k]),
            "high": float(known.high[k]),
            "told": found.states[k],
            "began": free.starts[name],
            "tolerance": tolerances(found)[name],
            "unit": free.unit(name),
        }
        for k, name in enumerate(free.names)
    }
    late = found.told.sample_time * np.array([found.found.fit.late, *known.late])
    data: Json = {
        "format": "hfc-design-identified",
        "version": 1,
        "log": found.log,
        "plant": free.drive.name,
        "confidence": CONFIDENCE,
        "parameters": parameters,
        "command_late_s": dict(zip(("value", "low", "high"), map(float, late), strict=True)),
        "replayed_under": found.how,
        "position_unit": found.position_unit,
        "rms": dict(zip(found.told.outputs, map(float, found.found.fit.rms), strict=True)),
        "checks": [
            {"log": one.log, "how": one.how, "rms_before": one.before, "rms": one.after}
            for one in found.checks
        ],
        "lag_s": found.told.sample_time * found.found.fit.lag,
        "model_check": _response(found.response),
        "untold": untold_lines(found),
        "record_next": advice_line(found),
        "notes": list(found.notes),
    }
    told: Json = _finite(data)
    return told


def _response(found: Response | None) -> Json | None:
    if found is None:
        return None
    return {
        "mode_hz": found.mode,
        "unknown_above_hz": found.unknown_above,
        "coloured": found.coloured / LAGS,
        "coherence": np.stack([found.frequency, found.coherence], axis=1).tolist(),
    }


def _finite(part: Any) -> Any:
    """Numbers that are none become None."""
    if isinstance(part, dict):
        return {key: _finite(value) for key, value in part.items()}
    if isinstance(part, list):
        return [_finite(one) for one in part]
    lost = isinstance(part, float) and not np.isfinite(part)
    return None if lost else part
