"""The estimators that the workspace or a package adds to studies (docs/extensions.md)."""

from ur5lib.force.estimators import OWN
from ur5rivals.estimator import Contender, ready

ESTIMATORS = [
    Contender(estimator.label, "of this workspace", False, ready(name))
    for name, estimator in OWN.items()
]
