"""The fit of torque constants and friction, and the index of contact-free runs."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from ur5lib.channels import CURRENT, EFFORTS, Effort
from ur5lib.errors import Remark
from ur5lib.robots.friction import coefficient_names
from ur5lib.tables import BY_KEY
from ur5lib.timeseries.arrays import Array

MAX_PRIOR_SHARE = 0.5  # of a parameter that the data determine
# Names of a joint's total friction begin with this; the velocity [rad/s] follows.
TOTAL = "total_"


@dataclass(frozen=True)
class CoefficientEstimate:
    """The estimated coefficients of one joint's map from motion to current.

    coefficients: (P,), of the torque [A/Nm], an offset [A] and friction terms; shares: (4, P), of
    the information on them, see `shares_of_knowledge`; replicates: (B, P), of the bootstrap over
    recordings; std_error: (P,), of the parameters that `physical_values` returns.
    """

    coefficients: Array
    shares: Array
    replicates: Array
    std_error: Array

    @property
    def prior_share(self) -> Array:
        """Return the share (P,) of the variance from the prior."""
        return self.shares[0]


@dataclass(frozen=True)
class JointFit:
    """One joint's map from motion to current.

    terms: of friction; held: (1 + D,) [A], friction at rest in excess of that in motion, may be
    negative, and its parts that reverse over D other distances [rad], see `held_columns`;
    band_moving, band_reversing, band_standing, band_unknown: half-width of the 95 % band [A] of a
    left-out recording's low-passed current, by its `MotionState`, without the variation from day to
    day; unseen: (P,), see `unseen_difference`; remarks: doubts about the fit; doubt: (P, P),
    covariance of the coefficients if no left-out motion shows their errors; alone: (P,), the
    coefficients without the prior, None unless their torque constant contradicts the documented
    one, which the estimate then keeps; alone_half: half-width of the 95 % interval of 1/k in
    `alone` [A/Nm].
    """

    terms: tuple[str, ...]
    distances: tuple[float, ...]
    estimate: CoefficientEstimate
    held: Array
    band_moving: float
    band_reversing: float
    band_standing: float
    band_unknown: float
    unseen: Array
    remarks: tuple[Remark, ...]
    doubt: Array | None = None
    alone: Array | None = None
    alone_half: float = 0.0

    def names(self) -> list[str]:
        """Return the parameters' names."""
        return ["torque_constant", "offset", *coefficient_names(self.terms)]

    @property
    def bands(self) -> tuple[float, ...]:
        """Half-widths of the 95 % band [A], in the order of `MotionState`."""
        return self.band_moving, self.band_reversing, self.band_standing, self.band_unknown

    @property
    def contradicted(self) -> float | None:
        """The torque constant [Nm/A] that contradicts the documented one, else None."""
        return None if self.alone is None else float(1 / self.alone[0])

    def surely_above(self, known: float) -> bool:
        """Return whether 1/k, with its 95 % interval, is below 1/known: k > known [Nm/A] or k < 0.

        k: the contradicting torque constant.
        """
        return self.alone is not None and float(self.alone[0]) + self.alone_half < 1 / known

    def std_error(self) -> Array:
        """Return the standard errors (P,) of the parameters, including variation between days."""
        return np.hypot(self.estimate.std_error, self.unseen)


@dataclass(frozen=True)
class CurrentFit:
    """The fit of an arm's joints: their maps from motion to current.

    units: number of paths, or of unbroken parts of recordings if paths are few; dates: those that
    the study gives for the recordings, ISO 8601.
    """

    joints: tuple[JointFit, ...]
    units: int
    dates: tuple[str, ...] = ()


@dataclass(frozen=True)
class Parameter:
    """One fitted value in SI units, or the friction of all terms; joint 1 to 6; interval: 95 %.

    prior_share, arm_share, day_share, run_share: shares of the information on the value, see
    `shares_of_knowledge`.
    """

    joint: int
    name: str
    value: float
    std_error: float
    interval: tuple[float, float]
    prior_share: float
    arm_share: float
    day_share: float
    run_share: float
    determined: bool

    @property
    def rests_on_prior(self) -> bool:
        """Return whether the prior (other arms) contributes most of the information."""
        return self.prior_share > MAX_PRIOR_SHARE


NO_FIT = CurrentFit((), 0)


@dataclass(frozen=True)
class LeftOut:
    """A fit that leaves out the paths of some recordings, used to judge these recordings."""

    recordings: list[str]
    fit: CurrentFit


@dataclass(frozen=True)
class KnownConstants:
    """Documented torque constants (6,) [Nm/A], and their standard errors."""

    value: Array
    std_error: Array


@dataclass(frozen=True, kw_only=True)
class Friction:
    """friction.json: the map from motion to motor current of an arm.

    from_: the fitted recordings in motion, empty if the friction is only the prior; at_rest: the
    fitted recordings of postures, which determine only torque constants; paths: number of
    trajectories; period: the longest step between samples [s], None without any; left_out: fits
    without some paths; usual: of one path, the fit without any recording, which has a part in
    predictions at rest; explained: (6,), share of the currents' variance that the fits without some
    paths explain on these, None with a single path; load: (6,) [Nm], mean |torque of the links| in
    motion, NaN for a joint that does not move, None without recordings; fastest: (6,) [rad/s], the
    largest speed in these, likewise; totals: friction of all terms at that load, see
    `total_friction`; least_squares: (6, 4), the baseline's coefficients;
    cross_validation: (R, R, 6) [A], RMSE of a fit to one recording, tested on another; model: link
    model of the torques; stopped: how the recordings contradict the arm; refused: other reasons why
    there is no fit; remarks: contradictions that the study accepts; effort: the predicted quantity
    of `channels.Effort`; touched: from and to [s] of contacts that check finds in fitted
    recordings, by name, which are left out.
    """

    __pydantic_config__ = BY_KEY

    from_: list[str] = field(default_factory=list)
    at_rest: list[str] = field(default_factory=list)
    paths: int = 0
    period: float | None = None
    fit: CurrentFit = NO_FIT
    left_out: list[LeftOut] = field(default_factory=list)
    usual: CurrentFit | None = None
    explained: Array | None = None
    parameters: list[Parameter] = field(default_factory=list)
    load: Array | None = None
    fastest: Array | None = None
    totals: list[Parameter] = field(default_factory=list)
    known_constants: KnownConstants | None = None
    least_squares: Array = field(default_factory=lambda: np.zeros((0, 4)))
    cross_validation: Array = field(default_factory=lambda: np.zeros((0, 0, 6)))
    model: str = ""
    stopped: Remark | None = None
    refused: Remark | None = None
    remarks: list[Remark] = field(default_factory=list)
    effort: str = CURRENT.quantity
    touched: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    @property
    def measured(self) -> Effort:
        """Return the predicted effort: currents, or torques, with gains in place of constants."""
        return EFFORTS[self.effort]

    def fit_for(self, recording: str) -> CurrentFit:
        """Return the fit without a recording's path, or the fit to all if there is none."""
        return next((own.fit for own in self.left_out if recording in own.recordings), self.fit)


def without_totals(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of friction.csv except those of total friction."""
    return rows[~rows["parameter"].astype(str).str.startswith(TOTAL)]
