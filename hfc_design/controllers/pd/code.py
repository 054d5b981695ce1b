"""The PD law in C and in Structured Text."""

from pathlib import Path
from typing import Any

from hfc_design.controllers.kind import Template
from hfc_design.controllers.pd.record import PdDesign

HERE = (Path(__file__).parent / "templates",)


def _st(record: PdDesign) -> dict[str, Any]:
    return {"constants": record.gains()._asdict()}


C = Template(HERE, lambda record: {"pd": record.pd})
ST = Template(HERE, _st)
