"""The estimators that the workspace or a package adds to studies (docs/extensions.md)."""

from ur5lib.force.estimators import OWN
from ur5lib.leaderboard.estimator import Estimator, ready

ESTIMATORS = [
    Estimator(one.label, "of this workspace", False, ready(name)) for name, one in OWN.items()
]
