"""The controller's own estimate, and the thesis's, as the study rebuilds them. Neither has a band.

`actual_TCP_force` is what Universal Robots' controller streams; on an e-Series arm, it is the wrist
sensor's, and `wrench_calc_from_currents` is computed from currents. Their methods and latencies are
not published. F̂* = J⁻ᵀ (k i + b - τ_C - τ_fr) is Equation 6.9 of the thesis, with its printed
constants and its low-pass without delay; F̂ is the same without the friction τ_fr (6.8).
"""

from ur5lib.force.estimators import ESTIMATES
from ur5rivals.estimator import Contender, ready

CONTROLLER_LABEL = ESTIMATES["controller_currents"]
ESTIMATORS = [
    Contender("controller, F̂ᵘ", "`actual_TCP_force`, Universal Robots", True, ready("Fu")),
    Contender(
        CONTROLLER_LABEL,
        "`wrench_calc_from_currents`, Universal Robots",
        True,
        ready("controller_currents"),
    ),
    Contender("thesis, F̂", "thesis 2014, Equation 6.8", False, ready("F")),
    Contender("thesis, F̂*", "thesis 2014, Equation 6.9", False, ready("F*")),
]
