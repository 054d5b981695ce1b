"""Linear controllers with feed-forward: PID tuned by a search, and optimal regulators.

All have one law. Of ``pid+ff`` every gain is searched; of ``lqr`` and ``lqi`` weights are, and the
gains follow from them and from the linearised drive.
"""

from hfc_design.controllers.linear.record import LqiDesign, LqrDesign, PidDesign

KINDS = (PidDesign, LqrDesign, LqiDesign)
