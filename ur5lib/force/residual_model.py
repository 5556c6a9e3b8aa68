"""Statistics of the external torque without contact: a slow background and a fast error."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.special import ndtri, stdtrit

from ur5lib.errors import RefusalError, Remark
from ur5lib.force.external_torque import FITTED_STATE_COUNT, RELAXATION_TIME, JointState, States
from ur5lib.records.codes import CauseCode
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import STD_PER_MAD

SHORT_LAG = 0.5  # s: half the duration of a push by hand
LONG_LAG = 2.0  # s: twice its duration
MIN_RENEWAL_RATE = 1 / 30  # 1/s; the background renews at least this fast
USUAL_STICTION = 0.4  # in breakaway torques: `stiction` where no recording rests
RUBBING_SHARE = 1.25  # `rubbing` over the standard deviation in motion
USUAL_RUBBING = 0.2  # in breakaway torques: `rubbing` where nothing was fitted
USUAL_REST_STD = 0.3  # in breakaway torques: deviation of a settling or resting joint
USUAL_REST_CHANGE = 0.2  # in breakaway torques: fast error while the whole arm rests
JOINTS_OF_A_FORCE = 2  # the torques of this many joints decide a component of a force
SHOWN_DURATION = 10.0  # s; rest or settling of this duration weighs as much as the usual
GATE_PATHS = 5  # the gate's deviations grow as for at least this many paths
MIN_STD_SHARE = 1e-3  # a torque's standard deviation is at least this share of breakaway
# The background of a joint that rests since a tare has at most this standard deviation, in
# breakaway torques, and this rate of renewal, which is that of a joint that nobody touches.
TARED_SPREAD_SHARE = 0.15
TARED_RENEWAL_RATE = 1e-3  # 1/s


class TorqueStretch(NamedTuple):
    """External torque (N, n) [Nm] and joint states (N, n) of a part without a gap; period: [s]."""

    torque: Array
    states: States
    period: float


@dataclass(frozen=True)
class ResidualModel:
    """External torque without contact: a background (Ornstein-Uhlenbeck) and a fast error.

    spread, change: (S, n) [Nm], by joint state, of n joints: standard deviations of the sum, and of
    the fast error, which changes within SHORT_LAG; rate: (S,) [1/s], at which the background
    renews; independent: [s], between independent values of the fast error; breakaway: (n,) [Nm], up
    to which dry friction keeps a joint at rest; doubt: further factor on intervals of forces if few
    paths were fitted; constants_doubt: (n,), relative standard deviations of the torque constants;
    sensed: whether the torques come from sensors at the links, behind the gears; usual: whether the
    model is that of other arms: then the background at rest may be a slow press; stiction, rubbing:
    what friction may take of a contact at rest and in motion, in breakaway torques.
    """

    spread: Array
    change: Array
    rate: Array
    independent: float
    breakaway: Array
    doubt: float = 1.0
    constants_doubt: Array | float = 0.0
    sensed: bool = False
    usual: bool = False
    stiction: float = USUAL_STICTION
    rubbing: float = USUAL_RUBBING

    @property
    def cutoff(self) -> float:
        """Return the cut-off [Hz] of the torques' low-pass, which leaves independent values."""
        return 1 / (2 * self.independent)

    def variance(self, of: Array, states: States) -> Array:
        """Return the variances (N, n) [N²m²] at each sample; of: `spread` or `change`."""
        return np.asarray(of[states, np.arange(states.shape[1])] ** 2)

    def wider(self, factor: float) -> "ResidualModel":
        """Return the model with all standard deviations multiplied by a factor."""
        return replace(self, spread=factor * self.spread, change=factor * self.change)

    def at_least(self, usual: "ResidualModel", share: Array | float) -> "ResidualModel":
        """Return the model with deviations raised by `share` (0 to 1) towards the usual ones where
        those are larger.

        σ² + share max(0, σ_usual² - σ²), of all standard deviations.
        """

        def mixed(std: Array, usual_std: Array) -> Array:
            return np.sqrt(std**2 + share * np.maximum(0.0, usual_std**2 - std**2))

        return replace(
            self,
            spread=mixed(self.spread, usual.spread),
            change=mixed(self.change, usual.change),
        )

    def with_usual_rest(self, stretches: Sequence[TorqueStretch]) -> "ResidualModel":
        """Return the model with deviations at rest and at stops mixed with usual ones, the more the
        less time the recordings show there.

        stretches: those that the model was fitted to. Sets `rubbing` to RUBBING_SHARE of the
        deviation in motion, and `stiction` to half of the deviation at rest.
        """
        seconds = _seconds(stretches, len(self.breakaway))
        unshown = SHOWN_DURATION / (SHOWN_DURATION + seconds)
        usual = replace(self, spread=self.spread.copy(), change=self.change.copy())
        usual.spread[JointState.SETTLING :] = USUAL_REST_STD * self.breakaway
        usual.change[JointState.SETTLING] = USUAL_REST_STD * self.breakaway
        usual.change[JointState.STILL] = USUAL_REST_CHANGE * self.breakaway
        # root mean squares over the joints, of the states
        shares = np.sqrt(np.mean((self.spread / self.breakaway) ** 2, axis=1))
        weight = unshown[JointState.STILL].max()
        return replace(
            self.at_least(usual, unshown),
            rubbing=float(RUBBING_SHARE * shares[JointState.MOVING]),
            stiction=float(weight * USUAL_STICTION + (1 - weight) * shares[JointState.STILL] / 2),
        )

    def with_tare(self) -> "ResidualModel":
        """Return the model with a further state TARED: as STILL, but with a background that renews
        very slowly.
        """
        spread = np.minimum(self.spread[JointState.STILL], TARED_SPREAD_SHARE * self.breakaway)
        change = np.minimum(self.change[JointState.STILL], spread)
        return replace(
            self,
            spread=np.vstack([self.spread, spread]),
            change=np.vstack([self.change, change]),
            rate=np.append(self.rate, TARED_RENEWAL_RATE),
        )

    def of_few_paths(self, paths: int) -> "ResidualModel":
        """Return the model widened by Student's t for a number of paths, in its deviations and in
        `doubt`.

        The deviations, which a contact has to exceed, grow as for at least GATE_PATHS paths: with
        the factor for one path, almost no push would be found. The rest of the factor goes into
        `doubt`.
        """
        # what the deviations do not take goes into the bands
        factor = few_paths(paths)
        inside = min(factor, few_paths(GATE_PATHS))
        return replace(self.wider(inside), doubt=factor / inside)


@dataclass(frozen=True)
class Residuals:
    """The residual model of an arm's external torque, tau_ext, None where it has none.

    refused: why there is none although friction was fitted; remarks: what the fit recordings do not
    show; contacts: from and to [s], by recording, that hide in these and were left out.
    """

    tau_ext: ResidualModel | None = None
    refused: Remark | None = None
    remarks: tuple[Remark, ...] = ()
    contacts: Mapping[str, list[tuple[float, float]]] = field(default_factory=dict)


def fit_residual_model(
    stretches: Sequence[TorqueStretch], cutoff: float, breakaway: Array, by_medians: bool = False
) -> ResidualModel:
    """Return the residual model fitted by moments to contact-free parts of recordings.

    cutoff: [Hz], of the low-pass of the torques, which leaves one independent value per 1 / (2
    cutoff); breakaway: (n,) [Nm]; by_medians: whether a mean square is at most that of a normal
    error with the same median, which contacts in less than half of the time change little. The
    variogram E[(x(t + h) - x(t))²] / 2 at two lags separates fast error and background. A state
    that no part contains has the largest deviations of the others. Raises RefusalError if no part
    is as long as the longer lag, or a joint never moves.
    """
    # E[x²], and the variogram at both lags
    short, long = (
        [_differences(stretch, lag) for stretch in stretches] for lag in (SHORT_LAG, LONG_LAG)
    )
    joints, moments = len(breakaway), _typical_moments if by_medians else _moments
    # (S, n) each
    mean_square, short_variogram, long_variogram = (
        moments(parts, joints) for parts in (stretches, short, long)
    )
    if not np.isfinite(long_variogram).any():
        text = (
            f"no contact-free recording has {LONG_LAG:g} s without a gap; add a longer recording "
            "with the role “fit”"
        )
        raise RefusalError(CauseCode.SHORT_RECORDINGS, text)
    still = (np.flatnonzero(np.isnan(mean_square[JointState.MOVING])) + 1).tolist()
    if still:
        text = (
            f"no contact-free recording moves joint {', '.join(map(str, still))}: its friction in "
            "motion is known from other arms at best; record a motion of all joints"
        )
        raise RefusalError(CauseCode.STILL_JOINTS, text)
    least = (MIN_STD_SHARE * breakaway) ** 2
    change = np.sqrt(_filled_moments(short_variogram, least))
    return ResidualModel(
        spread=np.maximum(np.sqrt(_filled_moments(mean_square, least)), change),
        change=change,
        rate=_rates((long_variogram - short_variogram) / mean_square / (LONG_LAG - SHORT_LAG)),
        independent=1 / (2 * cutoff),
        breakaway=breakaway,
    )


def few_paths(paths: int) -> float:
    """Return the factor by which a 95 % band from few paths is wider: Student's t over the normal
    quantile.

    JOINTS_OF_A_FORCE joints show a force's error independently along a path. One path counts as
    two: it does not determine the variation between paths.
    """
    freedom = JOINTS_OF_A_FORCE * max(1, paths - 1)
    return float(stdtrit(freedom, 0.975) / ndtri(0.975))


def _rates(growth: Array) -> Array:
    """Return the rate (S,) [1/s] of each state at which the background renews: the median over the
    joints, MIN_RENEWAL_RATE for a state without data.

    growth: (S, n) [1/s]. A joint that stops has a new, random friction torque, so while settling
    and resting the background renews within a second; there are too few stops for the median to
    show it.
    """
    rates_by_state = [row[np.isfinite(row)] for row in growth]
    rates = [
        max(np.median(r), MIN_RENEWAL_RATE) if len(r) else MIN_RENEWAL_RATE for r in rates_by_state
    ]
    stopped = np.isin(np.arange(len(rates)), (JointState.SETTLING, JointState.RESTING))
    return np.where(stopped, np.maximum(rates, 1 / RELAXATION_TIME), rates)


def _differences(stretch: TorqueStretch, seconds: float) -> TorqueStretch:
    """Return the changes of the torque over some seconds, (x(t + h) - x(t)) / sqrt 2, with the
    least certain state of each joint in between.
    """
    lag = max(1, round(seconds / stretch.period))
    torque, states = stretch.torque, stretch.states
    middle = slice(lag // 2, lag // 2 + max(0, len(torque) - lag))
    for state in (JointState.REVERSING, JointState.SETTLING):  # passed within the lag
        inside = (stretch.states == state).astype(np.uint8)
        states = np.where(maximum_filter1d(inside, lag + 1, axis=0) > 0, state, states)
    change = (torque[lag:] - torque[: max(0, len(torque) - lag)]) / np.sqrt(2)
    return TorqueStretch(change, states[middle], stretch.period)


def _moments(stretches: Sequence[TorqueStretch], joints: int) -> Array:
    """Return mean squares (S, n) over time by state and joint; NaN for a state without data."""
    total, seconds = np.zeros((FITTED_STATE_COUNT, joints)), _seconds(stretches, joints)
    for torque, states, period in stretches:
        for state in range(FITTED_STATE_COUNT):
            in_state = (states == state) & np.isfinite(torque)
            total[state] += period * (np.where(in_state, torque, 0.0) ** 2).sum(axis=0)
    return np.where(seconds > 0, total / np.maximum(seconds, 1e-9), np.nan)


def _typical_moments(stretches: Sequence[TorqueStretch], joints: int) -> Array:
    """Return `_moments`, but at most those of normal errors with the same medians."""
    found = _moments(stretches, joints)
    for state, joint in np.ndindex(*found.shape):
        rows = [torque[states[:, joint] == state, joint] for torque, states, _ in stretches]
        sizes = np.abs(np.concatenate(rows))
        if np.isfinite(sizes).any():
            typical = (STD_PER_MAD * np.nanmedian(sizes)) ** 2
            found[state, joint] = min(found[state, joint], typical)
    return found


def _seconds(stretches: Sequence[TorqueStretch], joints: int) -> Array:
    """Return the time (S, n) [s] with a torque by state and joint."""
    seconds = np.zeros((FITTED_STATE_COUNT, joints))
    for torque, states, period in stretches:
        for state in range(FITTED_STATE_COUNT):
            seconds[state] += period * ((states == state) & np.isfinite(torque)).sum(axis=0)
    return seconds


def _filled_moments(moments: Array, least: Array) -> Array:
    """Return moments (S, n) with NaN replaced by the joint's largest, and all at least `least`
    (n,).
    """
    largest = np.nanmax(moments, axis=0)
    return np.maximum(np.where(np.isfinite(moments), moments, largest), least)
