"""Bands of the end effector's acceleration: how far encoders and IMU differ in other recordings."""

from collections.abc import Iterator, Mapping

import numpy as np

from ur5lib.records.acceleration_errors import AccelerationBand
from ur5lib.records.accelerations import COMPONENTS, Difference, ImuComparison
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95


def acceleration_bands(
    accelerations: ImuComparison, every: Mapping[str, ImuComparison]
) -> Iterator[AccelerationBand]:
    """Yield a recording's RMS differences between encoders and IMU by range of frequency, in motion
    and at rest, with the share of samples within the band, and the same of filterpy's plain
    smoother.

    accelerations: of the recording; every: of all recordings, by name. The band comes from the
    other recordings and contains all errors: noise of encoders and IMU, calibration, bending links.
    No rows without another recording.
    """
    known = (every[name] for name in accelerations.calibrated_on if name in every)
    ranges = [one.ranges for one in known if one is not accelerations]  # of the others
    for name, states in accelerations.ranges.items():
        for state, found in states.items():
            squares = [part.square for one in ranges if (part := one.get(name, {}).get(state))]
            if squares:
                std = np.sqrt(np.mean(squares, axis=0))
                plain = accelerations.plain_ranges[name][state].square
                yield from _bands(name, state, found, std, plain)


def _bands(
    name: str, during: str, found: Difference, std: Array, plain: Array
) -> Iterator[AccelerationBand]:
    levels = np.linspace(0, 1, len(found.quantiles))  # of the absolute values
    for index, (component, unit) in enumerate(COMPONENTS.items()):
        held = np.interp(NORMAL95 * std[index], found.quantiles[:, index], levels)
        yield AccelerationBand(
            range=name,
            during=during,
            component=component,
            unit=unit,
            rms=float(np.sqrt(found.square[index])),
            std=float(std[index]),
            held=float(held),
            filterpy_rms=float(np.sqrt(plain[index])),
        )
