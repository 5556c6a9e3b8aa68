"""This project's estimates, as the study holds them (docs/methods.md)."""

from benchmarks.harness.estimator import Estimator, ready

OURS = "F̂ᵐᵃᵖ"

ESTIMATORS = [
    Estimator(OURS, "ours", False, ready("Fmap")),
    Estimator("F̂ᵐᵃᵖ of the momentum observer", "ours", False, ready("observer")),
    Estimator("F̂ᵐᵃᵖ, repeat-aware", "ours", False, ready("repeat")),
]
