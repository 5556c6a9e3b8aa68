"""This project's gated estimates, as the study has them (docs/methods.md)."""

from ur5lib.force.estimators import ESTIMATES, GATED, LEADING
from ur5rivals.estimator import Contender, ready

OURS = ESTIMATES[LEADING]
ESTIMATORS = [
    Contender(OURS if name == LEADING else f"{OURS}, {ESTIMATES[name]}", "ours", False, ready(name))
    for name in GATED
]
