"""This project's gated estimates, as the study holds them (docs/methods.md)."""

from ur5lib.force.estimators import ESTIMATES, GATED
from ur5lib.leaderboard.estimator import Estimator, ready

OURS = ESTIMATES["Fmap"]


def _called(name: str) -> str:
    return OURS if name == "Fmap" else f"{OURS}, {ESTIMATES[name]}"


ESTIMATORS = [Estimator(_called(name), "ours", False, ready(name)) for name in GATED]
