"""Postures at rest: torque constants by the currents that balance gravity there.

i = (τ + f - b) / k, with a static friction f anywhere within ± Coulomb friction, which depends on
how the arm came to rest and adds a variance. Its mean differs between recordings; therefore each
recording's mean is subtracted from torques and currents.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels

POSTURES_PER_STRETCH = 5  # this many in a row may have been reached in the same way
MIN_STRETCHES = 5  # with fewer, single postures are resampled


@dataclass(frozen=True)
class AtRest:
    """Postures of an arm at rest, each with a static friction of its own.

    torque: (M, n) [Nm], of the rigid-body model; current: (M, n) [A], both minus their means over
    the recording; record: (M,) labels of the recordings.
    """

    torque: Array
    current: Array
    record: Labels

    @classmethod
    def of(cls, recordings: Sequence[tuple[Array, Array]]) -> "AtRest | None":
        """Return the postures of all recordings, None if there are none.

        recordings: torques [Nm] and currents [A] of each, (M, n); their means are subtracted.
        """
        if not recordings:
            return None
        torque, current = (
            np.concatenate([values - values.mean(axis=0) for values in quantity])
            for quantity in zip(*recordings, strict=True)
        )
        sizes = [len(torques) for torques, _ in recordings]
        return cls(torque, current, np.repeat(np.arange(len(sizes)), sizes))

    def stretches(self) -> Labels:
        """Return labels (M,) of the units that a bootstrap draws: POSTURES_PER_STRETCH postures in
        a row, or single ones if these are few.
        """
        posture = np.arange(len(self.record))
        stretch = posture // POSTURES_PER_STRETCH
        return stretch if stretch[-1] + 1 >= MIN_STRETCHES else posture
