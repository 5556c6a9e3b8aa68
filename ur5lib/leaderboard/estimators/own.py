"""The estimators that the working folder or a package adds to studies (docs/extensions.md)."""

from ur5lib.leaderboard.estimator import Contender, ready
from ur5lib.pipeline.estimators import OWN

ESTIMATORS = [
    Contender(estimator.label, "of this lab", False, ready(name)) for name, estimator in OWN.items()
]
