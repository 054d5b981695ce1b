"""Linear controllers with feed-forward: PID tuned by a search, and optimal regulators.

All have the same law. The search varies every gain of ``pid+ff``; for ``lqr`` and ``lqi`` it
varies weights, from which the gains follow, with the linearised drive.
"""

from hfc_design.controllers.linear.record import LqiDesign, LqrDesign, PidDesign

KINDS = (PidDesign, LqrDesign, LqiDesign)
