"""The fit of torque constants and friction, and the index of contact-free runs."""

from dataclasses import dataclass, field

import numpy as np

from ur5lib.channels import CURRENT, EFFORTS, Effort
from ur5lib.errors import Remark
from ur5lib.identification.currents import CurrentFit, Parameter
from ur5lib.tables import BY_KEY
from ur5lib.timeseries.arrays import Array

NO_FIT = CurrentFit((), 0)


@dataclass(frozen=True)
class LeftOut:
    """A fit without the paths of some recordings, by which these are judged."""

    recordings: list[str]
    fit: CurrentFit


@dataclass(frozen=True)
class KnownConstants:
    """Torque constants (6,) [Nm/A] that are known before the fit, and their standard errors."""

    value: Array
    std_error: Array


@dataclass(frozen=True, kw_only=True)
class Friction:
    """friction.json: the map from motion to motor current of an arm.

    from_: the recordings in motion of the fit, none where friction is what other arms have;
    at_rest: those of postures, which tell torque constants alone; paths: number of trajectories;
    period: the longest step between their samples [s], None without any;
    left_out: fits that predict what they have not seen; explained: (6,), share of the currents'
    variance that these explain, None of a single path; least_squares: (6, 4), the baseline's
    coefficients; cross_validation: (R, R, 6) [A], RMSE of a fit to one recording, tested on
    another; model: link model of the torques; stopped: how the recordings contradict the arm;
    refused: why else there is no fit; remarks: what the fit contradicts, but the study accepts;
    effort: the quantity of `channels.Effort` that is predicted.
    """

    __pydantic_config__ = BY_KEY

    from_: list[str] = field(default_factory=list)
    at_rest: list[str] = field(default_factory=list)
    paths: int = 0
    period: float | None = None
    fit: CurrentFit = NO_FIT
    left_out: list[LeftOut] = field(default_factory=list)
    explained: Array | None = None
    parameters: list[Parameter] = field(default_factory=list)
    known_constants: KnownConstants | None = None
    least_squares: Array = field(default_factory=lambda: np.zeros((0, 4)))
    cross_validation: Array = field(default_factory=lambda: np.zeros((0, 0, 6)))
    model: str = ""
    stopped: Remark | None = None
    refused: Remark | None = None
    remarks: list[Remark] = field(default_factory=list)
    effort: str = CURRENT.quantity

    @property
    def measured(self) -> Effort:
        """Return what is predicted: currents, or torques, whose torque constants are gains."""
        return EFFORTS[self.effort]

    def fit_for(self, recording: str) -> CurrentFit:
        """Return the fit without a recording's path, or the only one there is."""
        return next((own.fit for own in self.left_out if recording in own.recordings), self.fit)
