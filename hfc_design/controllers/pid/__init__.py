"""The proportional-integral-derivative controller of a feed drive."""

from hfc_design.controllers.gains import genome_of_gains, settings_of
from hfc_design.controllers.kind import Kind
from hfc_design.controllers.pid.code import ST, C
from hfc_design.controllers.pid.law import PidGains, pid
from hfc_design.controllers.pid.record import PidDesign

KIND = Kind(
    name="pid",
    summary="proportional-integral-derivative on an error in BLU",
    record=PidDesign,
    #: On a feed drive, an error in BLU: units/BLU, units/(BLU s), units s/BLU.
    settings=settings_of(PidGains(k_p=(0.1, 20.0), k_i=(0.0, 50.0), k_d=(0.0, 1.0))),
    gains=PidDesign.gains,
    law=lambda record, limit: pid(record.sample_time_s, limit),
    genome=genome_of_gains,
    reads=lambda record: ["error"],
    of_gains=lambda gains: {"pid": gains},
    c=C,
    st=ST,
)
