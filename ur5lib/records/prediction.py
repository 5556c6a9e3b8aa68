"""The errors of predicted currents, and the arm's load estimated from them."""

from dataclasses import dataclass, field

import numpy as np

from ur5lib.records.phrases import number
from ur5lib.robots.description import Payload
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class Scores:
    """The errors of one prediction of a recording's currents, (6,) each.

    rmse: of the raw current [A]; of the low-passed current: rmse_lowpassed [A], mae [A], r2,
    coverage, the share of samples inside the 95 % band, and band_factor95, the multiple of the band
    that contains 95 % of them; rmse_before_motion, coverage_before_motion: the same until a joint
    first moves, where the sign of friction is unknown, NaN without such samples.
    """

    rmse: Array
    rmse_lowpassed: Array
    mae: Array
    r2: Array
    coverage: Array
    band_factor95: Array
    rmse_before_motion: Array
    coverage_before_motion: Array

    @property
    def zero_rmse_lowpassed(self) -> Array:
        """Return the RMSE (6,) [A] of a constant current, its mean: R² = 1 − RMSE² / zero²."""
        zero: Array = self.rmse_lowpassed / np.sqrt(1 - self.r2)
        return zero


@dataclass(frozen=True)
class LoadEstimate:
    """A load on the flange, estimated from currents.

    mass, std_error: [kg]; interval: of the mass, 95 % [kg]; certain: whether it is significant in
    all parts of the recording.
    """

    mass: float
    std_error: float
    interval: tuple[float, float]
    certain: bool


@dataclass(frozen=True)
class JudgedLoad(LoadEstimate):
    """An undeclared load in addition to the given payload, which has a mass `configured` [kg].

    carried: sum of both masses [kg]; taken: whether the prediction includes the load;
    center_of_mass: (3,) [m], with its standard error; NaN for an uncertain load.
    """

    configured: float
    carried: float
    taken: bool
    center_of_mass: Array
    center_of_mass_std: Array


def held_throughout(load: LoadEstimate) -> str:
    """Return in words that a load is not part of the stated force."""
    return f"{number(load.mass, '.2g')} kg held throughout, taken off the force"


@dataclass(frozen=True)
class Prediction:
    """currents.json: scores of a recording's predicted currents by model, and the arm's load.

    fitted: whether the fit used the recording.
    """

    fitted: bool
    scores: dict[str, Scores] = field(default_factory=dict)
    load: JudgedLoad | None = None

    @property
    def is_loaded(self) -> bool:
        """Return whether the prediction includes an undeclared load."""
        return self.load is not None and self.load.taken

    def with_load(self, payload: Payload | None) -> Payload | None:
        """Return the given payload joined with the undeclared load that the prediction includes, a
        point mass; the payload unchanged if it includes none.
        """
        if self.load is None or not self.load.taken:
            return payload
        x, y, z = self.load.center_of_mass.tolist()
        return Payload(mass=self.load.mass, center_of_mass=(x, y, z)).joined(payload)
