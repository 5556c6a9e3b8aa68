"""How far the external torque is from zero where nothing touches the arm."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple, Self

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.special import ndtri, stdtrit

from ur5lib.errors import InputError
from ur5lib.force.external_torque import (
    MOVING,
    RELAXING,
    RESTING,
    REVERSING,
    SETTLING,
    STATES,
    States,
    finite_rows,
)
from ur5lib.timeseries.arrays import Array, Mask

SHORT, LONG = 0.5, 2.0  # s: half a push of a hand, and twice one
SLOWEST, FASTEST = 1 / 30, 2.0  # 1/s, between which the slow part renews itself
LEAST = 1e-3  # Nm, no joint repeats better


class Stretch(NamedTuple):
    """External torque (N, 6) [Nm] and joint states (N, 6) without a gap; period: [s]."""

    torque: Array
    states: States
    period: float


@dataclass(frozen=True)
class ResidualModel:
    """Contact-free external torque: a slow part (Ornstein-Uhlenbeck) and a quick part.

    spread, change: (S, 6) [Nm], by joint state: standard deviation of the whole, and of what
    changes within half a push, the quick part; rate: (S,) [1/s], at which the slow part renews
    itself; correlation: (6, 6), between joints; independent: [s], between two values of the quick
    part that know nothing of each other; breakaway: (6,) [Nm], up to which dry friction holds a
    joint at rest.
    """

    spread: Array
    change: Array
    rate: Array
    correlation: Array
    independent: float
    breakaway: Array

    def covariance(self, of: Array, states: States) -> Array:
        """D C D at each sample, D from `spread` or `change`: (N, 6, 6) [Nm²]."""
        deviation = of[states, np.arange(6)]
        return deviation[:, :, None] * self.correlation * deviation[:, None, :]

    def wider(self, factor: float) -> "ResidualModel":
        """The same model with all deviations multiplied."""
        return replace(self, spread=factor * self.spread, change=factor * self.change)

    def beside(self, repeated: "ResidualModel") -> "ResidualModel":
        """Both models as one: the states of `repeated` are counted on from this model's."""
        return replace(
            self,
            spread=np.concatenate([self.spread, repeated.spread]),
            change=np.concatenate([self.change, repeated.change]),
            rate=np.concatenate([self.rate, repeated.rate]),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the model as plain numbers and lists, for JSON."""
        return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in asdict(self).items()}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """Return the model that `to_dict` was called on."""
        arrays = {k: np.array(v) for k, v in data.items() if isinstance(v, list)}
        return cls(**arrays, independent=data["independent"])


def fit_residual_model(
    stretches: Sequence[Stretch], cutoff: float, breakaway: Array
) -> ResidualModel:
    """Moments of the external torque over contact-free stretches.

    cutoff: [Hz], of the low-pass behind the torques: it leaves one independent value each
    1 / (2 cutoff); breakaway: (6,) [Nm]. The variogram E[(x(t + h) - x(t))²] / 2 at two lags parts
    quick from slow. A state that no stretch shows is given the largest deviations of the others.
    Raises InputError where no stretch is as long as the longer lag, or a joint never moves.
    """
    short, long = ([_differences(one, lag) for one in stretches] for lag in (SHORT, LONG))
    whole, near, far = _moments(stretches), _moments(short), _moments(long)
    if not np.isfinite(far).any():
        raise InputError(f"no contact-free stretch is as long as {LONG:g} s; name more recordings")
    still = [f"{joint + 1}" for joint in range(6) if np.isnan(whole[MOVING, joint])]
    if still:
        raise InputError(
            f"no contact-free recording moves joint {', '.join(still)}: what its motor needs in "
            "motion is unknown; record one in which all joints move"
        )
    change = np.sqrt(_filled(near))
    return ResidualModel(
        spread=np.maximum(np.sqrt(_filled(whole)), change),
        change=change,
        rate=_rates((far - near) / whole / (LONG - SHORT)),
        correlation=_correlation(short, change),
        independent=1 / (2 * cutoff),
        breakaway=breakaway,
    )


def few_paths(paths: int) -> float:
    """By how much a 95 % band widens when so few paths told its width (Student's t).

    One path cannot tell how far others differ: it counts as two.
    """
    return float(stdtrit(max(1, paths - 1), 0.975) / ndtri(0.975))


def _rates(growth: Array) -> Array:
    """Median over the joints, (S,) [1/s]; where no joint tells, the slow part stays.

    A joint that stops while others move draws anew what dry friction holds: within a second, though
    stops are too few among the samples for the median to say so.
    """
    told = [row[np.isfinite(row)] for row in growth]
    rates = [np.clip(np.median(r), SLOWEST, FASTEST) if len(r) else SLOWEST for r in told]
    stopped = np.isin(np.arange(len(rates)), (SETTLING, RESTING))
    return np.where(stopped, np.maximum(rates, 1 / RELAXING), rates)


def _differences(stretch: Stretch, seconds: float) -> Stretch:
    """(x(t + h) - x(t)) / sqrt 2, in the least known state that the joint passes in between."""
    lag = round(seconds / stretch.period)
    torque, states = stretch.torque, stretch.states
    middle = slice(lag // 2, lag // 2 + max(0, len(torque) - lag))
    for state in (REVERSING, SETTLING):
        states = np.where(_passed(stretch.states == state, lag), state, states)
    change = (torque[lag:] - torque[: max(0, len(torque) - lag)]) / np.sqrt(2)
    return Stretch(change, states[middle], stretch.period)


def _passed(where: Mask, lag: int) -> Mask:
    return np.asarray(maximum_filter1d(where.astype(np.uint8), lag + 1, axis=0) > 0)


def _moments(stretches: Sequence[Stretch]) -> Array:
    """Mean squares (S, 6) over time by state and joint; NaN for a state that is not there."""
    total, seconds = np.zeros((STATES, 6)), np.zeros((STATES, 6))
    for torque, states, period in stretches:
        for state in range(STATES):
            here = (states == state) & np.isfinite(torque)
            total[state] += period * (np.where(here, torque, 0.0) ** 2).sum(axis=0)
            seconds[state] += period * here.sum(axis=0)
    return np.where(seconds > 0, total / np.maximum(seconds, 1e-9), np.nan)


def _filled(moments: Array) -> Array:
    largest = np.nanmax(moments, axis=0)
    return np.maximum(np.where(np.isfinite(moments), moments, largest), LEAST**2)


def _correlation(differences: Sequence[Stretch], deviation: Array) -> Array:
    parts = [one.torque / deviation[one.states, np.arange(6)] for one in differences]
    scaled = np.concatenate(parts)
    return np.asarray(np.corrcoef(scaled[finite_rows(scaled)].T))
