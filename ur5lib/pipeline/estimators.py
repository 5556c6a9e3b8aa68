"""The estimators of the contact wrench: their names, and what each states of a recording.

Records, thresholds, tables, figures, the comparison with simulated truth and the benchmark take
ESTIMATORS as they stand here; the first that a recording has leads its figures and sentences.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

from ur5lib.timeseries.arrays import Array

if TYPE_CHECKING:  # whoever reads estimates need not load what makes them
    from ur5lib.force.wrench_estimate import WrenchEstimate
    from ur5lib.pipeline.force_run import ForceRun


class Stated(Protocol):
    """The environment on the arm, base axes, at the origin of frame 6.

    wrench and std, its standard deviation: (N, 6) [N, Nm], NaN where nothing is known; log_odds:
    (N,), that there is a contact, None of an estimator that is not gated.
    """

    @property
    def wrench(self) -> Array:
        """Return the wrench."""

    @property
    def std(self) -> Array:
        """Return its standard deviation."""

    @property
    def log_odds(self) -> Array | None:
        """Return the log-odds of contact."""


@dataclass(frozen=True)
class Estimator:
    """One estimator of the contact wrench.

    name: in records and tables; label: in reports; estimate: returns None where the recording lacks
    what the estimator needs; gated: whether it states odds of contact, so that it raises alarms;
    article: before the label in sentences.
    """

    name: str
    label: str
    estimate: "Callable[[ForceRun], Stated | None]"
    gated: bool = True
    article: str = ""


def fmap(run: "ForceRun") -> Stated | None:
    """Return the most probable wrench by the external torque."""
    return run.fmap


class WithoutPrior(NamedTuple):
    """The wrench by least squares in the contacts of another estimate."""

    of: "WrenchEstimate"
    log_odds: None = None

    @property
    def wrench(self) -> Array:
        """Return the wrench (N, 6) [N, Nm]."""
        return self.of.least_squares

    @property
    def std(self) -> Array:
        """Return its standard deviation (N, 6) [N, Nm]."""
        return self.of.least_squares_std


def least_squares(run: "ForceRun") -> Stated | None:
    """Return the wrench by least squares, in the contacts of F̂ᵐᵃᵖ."""
    return None if run.fmap is None else WithoutPrior(run.fmap)


def observer(run: "ForceRun") -> Stated | None:
    """Return the most probable wrench by the torque of the momentum observer."""
    return run.solved(run.problems.get("observer"))


def repeat(run: "ForceRun") -> Stated | None:
    """Return F̂ᵐᵃᵖ, less the external torque of the same trajectory without contact."""
    return run.solved(run.repeat())


def static(run: "ForceRun") -> Stated | None:
    """Return the estimate of a resting arm without any fit, where there is none."""
    if run.is_fitted:
        return None
    # slow to import, and friction of most arms is fitted
    from ur5lib.pipeline.static_forces import static_forces

    return static_forces(run)


ESTIMATORS = (
    Estimator("Fmap", "F̂ᵐᵃᵖ", fmap),
    Estimator("least_squares", "least squares", least_squares, gated=False),
    Estimator("observer", "observer", observer),
    Estimator("repeat", "repeat-aware", repeat),
    Estimator("static", "uncalibrated static estimate", static, gated=False, article="the "),
)
PUBLISHED = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}  # the controller's and the thesis's
NEW = {one.name: one.label for one in ESTIMATORS}
ESTIMATES = PUBLISHED | NEW
SPOKEN = PUBLISHED | {one.name: one.article + one.label for one in ESTIMATORS}  # as in sentences
GATED = [one.name for one in ESTIMATORS if one.gated]
