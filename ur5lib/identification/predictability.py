"""At which velocities a joint's friction is predicted: errors beside their band, by speed."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np

from ur5lib.timeseries.arrays import Array, Mask

SPEEDS = np.array([0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, np.inf])  # rad/s
WANTED = 0.9  # share of samples within the 95 % band
FEWEST = 20  # samples in a bin, 0.1 s apart


@dataclass(frozen=True)
class ShareBySpeed:
    """Share of a joint's errors within their band, and samples, (B,), between speeds `SPEEDS`.

    NaN in bins with less than FEWEST samples.
    """

    share: Array
    samples: Array

    def rows(self) -> Iterator[dict[str, float]]:
        """Yield each bin with its share and samples."""
        for (low, high), share, samples in zip(
            pairwise(SPEEDS), self.share, self.samples, strict=True
        ):
            yield {"speed_low": low, "speed_high": high, "share": share, "samples": samples}

    def suffices(self) -> tuple[float, float]:
        """Return the speeds [rad/s] from which and up to which every bin holds the wanted share.

        Infinite where the fastest known bin does, too. Of several such ranges, the one with most
        samples; NaN without any.
        """
        known = np.flatnonzero(np.isfinite(self.share))
        runs = [
            [int(place) for place in run]
            for enough, run in groupby(known, lambda place: self.share[place] >= WANTED)
            if enough
        ]
        if not runs:
            return np.nan, np.nan
        best = max(runs, key=lambda run: self.samples[run].sum())
        high = np.inf if best[-1] == known[-1] else float(SPEEDS[best[-1] + 1])
        return float(SPEEDS[best[0]]), high


def share_by_speed(speed: Array, inside: Mask) -> ShareBySpeed:
    """Return the share of samples within their band by speed; speed, inside: (N,) [rad/s]."""
    place, count = np.digitize(speed, SPEEDS) - 1, len(SPEEDS) - 1
    samples = np.bincount(place, minlength=count)
    held = np.bincount(place, weights=inside, minlength=count)
    share = np.where(samples >= FEWEST, held / np.maximum(samples, 1), np.nan)
    return ShareBySpeed(share, samples.astype(np.float64))
