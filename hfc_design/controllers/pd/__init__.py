"""The proportional-derivative controller that every fuzzy one is measured against."""

from hfc_design.controllers.gains import genome_of_gains, settings_of
from hfc_design.controllers.kind import Kind
from hfc_design.controllers.pd.code import ST, C
from hfc_design.controllers.pd.law import PdGains, pd
from hfc_design.controllers.pd.record import PdDesign

KIND = Kind(
    name="pd",
    summary="proportional-derivative: v = kp e + kd de/dt",
    record=PdDesign,
    #: On the C-axis [V/rad, V s/rad]; the ranges are those of the hierarchy beside it.
    settings=settings_of(PdGains(kp=(100.0, 10_000.0), kd=(30.0, 3_000.0))),
    gains=PdDesign.gains,
    law=lambda record, limit: pd(record.sample_time_s, limit),
    genome=genome_of_gains,
    of_gains=lambda gains: {"pd": gains},
    c=C,
    st=ST,
)
