"""What a search for a fuzzy controller that adapts starts from."""

from typing import Annotated, Literal

from pydantic import Field

from hfc_design.controllers.aflc.record import AflcDesign
from hfc_design.controllers.flc.settings import FuzzySettings, Start


class AflcSettings(FuzzySettings):
    """A fuzzy controller of a feed drive that adapts."""

    kind: Literal["aflc"]
    start: Annotated[AflcDesign, Start] = Field("jee-koren-2004-aflc", validate_default=True)
