"""How far the external torque is from zero where nothing touches the arm."""

from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from ur5lib.errors import InputError
from ur5lib.force.external_torque import STATES, TURNING, States, finite_rows

Array = NDArray[np.float64]
Stretch = tuple[Array, States]  # external torque (N, 6) [Nm] and joint states (N, 6), no gap

SHORT, LONG = 0.5, 2.0  # s: half a push of a hand, and twice one
SLOWEST, FASTEST = 1 / 30, 2.0  # 1/s, between which the slow part renews itself
LEAST = 1e-3  # Nm, no joint repeats better


@dataclass(frozen=True)
class ResidualModel:
    """Contact-free external torque: a slow part (Ornstein-Uhlenbeck) and a quick part.

    spread, change: (S, 6) [Nm], by joint state: standard deviation of the whole, and of what
    changes within half a push, the quick part; rate: (S,) [1/s], at which the slow part renews
    itself; correlation: (6, 6), between joints; independent: [s], between two values of the quick
    part that know nothing of each other.
    """

    spread: Array
    change: Array
    rate: Array
    correlation: Array
    independent: float

    def deviation(self, of: Array, states: States) -> Array:
        """`spread` or `change` at each sample: (N, 6) [Nm]."""
        return of[states, np.arange(6)]

    def covariance(self, of: Array, states: States) -> Array:
        """D C D at each sample, D from `spread` or `change`: (N, 6, 6) [Nm²]."""
        deviation = self.deviation(of, states)
        return deviation[:, :, None] * self.correlation * deviation[:, None, :]

    def beside(self, repeated: "ResidualModel") -> "ResidualModel":
        """Both models as one: the states of `repeated` are counted on from this model's."""
        return ResidualModel(
            spread=np.concatenate([self.spread, repeated.spread]),
            change=np.concatenate([self.change, repeated.change]),
            rate=np.concatenate([self.rate, repeated.rate]),
            correlation=self.correlation,
            independent=self.independent,
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain numbers and lists, for JSON."""
        return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in asdict(self).items()}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """What `to_dict` gave."""
        arrays = {k: np.array(v) for k, v in data.items() if isinstance(v, list)}
        return cls(**arrays, independent=data["independent"])


def fit_residual_model(stretches: list[Stretch], period: float, cutoff: float) -> ResidualModel:
    """Moments of the external torque, over unbroken contact-free stretches.

    period: [s]; cutoff: [Hz], of the low-pass behind the torques: it leaves one independent value
    each 1 / (2 cutoff). The variogram E[(x(t + h) - x(t))²] / 2 at two lags parts quick from slow.
    A state that no stretch shows is given the largest deviations of the others. Raises InputError
    when there is no stretch as long as the longer lag.
    """
    short, long = (_differences(stretches, round(lag / period)) for lag in (SHORT, LONG))
    whole, near, far = _moments(stretches), _moments(short), _moments(long)
    if not np.isfinite(far).any():
        raise InputError(f"no contact-free stretch is as long as {LONG:g} s; name more recordings")
    change = np.sqrt(_filled(near))
    return ResidualModel(
        spread=np.sqrt(_filled(whole)),
        change=change,
        rate=_rates((far - near) / whole / (LONG - SHORT)),
        correlation=_correlation(short, change),
        independent=1 / (2 * cutoff),
    )


def _rates(growth: Array) -> Array:
    """Median over the joints, (3,) [1/s]; where no joint tells, the slow part stays."""
    told = [row[np.isfinite(row)] for row in growth]
    return np.array([np.clip(np.median(r), SLOWEST, FASTEST) if len(r) else SLOWEST for r in told])


def _differences(stretches: list[Stretch], lag: int) -> list[Stretch]:
    """(x(t + h) - x(t)) / sqrt 2; a joint that turns in between is in the state TURNING."""
    pairs = []
    for torque, states in stretches:
        if len(torque) > lag:
            turns = maximum_filter1d((states == TURNING).astype(np.int64), lag + 1, axis=0) > 0
            middle = slice(lag // 2, lag // 2 + len(torque) - lag)
            between = np.where(turns, TURNING, states)[middle]
            pairs.append(((torque[lag:] - torque[:-lag]) / np.sqrt(2), between))
    return pairs


def _moments(stretches: list[Stretch]) -> Array:
    """Mean squares (3, 6) by state and joint; NaN for a state that is not there."""
    moments = np.full((STATES, 6), np.nan)
    if not stretches:
        return moments
    torque, states = (np.concatenate(parts) for parts in zip(*stretches, strict=True))
    for state in range(STATES):
        here = (states == state) & np.isfinite(torque)
        count = here.sum(axis=0)
        total = np.where(here, torque, 0.0) ** 2
        moments[state] = np.where(count > 0, total.sum(axis=0) / np.maximum(count, 1), np.nan)
    return moments


def _filled(moments: Array) -> Array:
    largest = np.nanmax(moments, axis=0)
    return np.maximum(np.where(np.isfinite(moments), moments, largest), LEAST**2)


def _correlation(differences: list[Stretch], deviation: Array) -> Array:
    parts = [torque / deviation[states, np.arange(6)] for torque, states in differences]
    scaled = np.concatenate(parts)
    return np.asarray(np.corrcoef(scaled[finite_rows(scaled)].T))
