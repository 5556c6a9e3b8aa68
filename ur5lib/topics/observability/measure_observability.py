"""How well the bands of currents cover an arm's contact-free recordings.

The share of each joint's efforts within their stated band, as a function of its speed.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.identification.currents import torque_constants
from ur5lib.identification.samples import INDEPENDENT_STEP
from ur5lib.identification.validation import (
    MIN_SAMPLES,
    SPEED_BINS,
    ShareBySpeed,
    share_by_speed,
)
from ur5lib.records.currents import Currents
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.step import step
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import BAND_COVERAGE
from ur5lib.topics.observability.rows import Observed


@step("arm", "observability.csv", recordings="drawn", predictions="prediction")
def measure_observability(
    motion: Mapping[str, Motion],
    currents: Mapping[str, Currents],
    predictions: Mapping[str, Prediction],
    friction: Friction,
) -> list[Observed]:
    """Return the coverage of the bands on an arm's contact-free recordings, by speed."""
    errors = list[Judged]()
    for name, moved in motion.items():
        predicted = currents[name]
        if predicted.external_torque is not None and not predictions[name].is_loaded:
            errors.append(judged(moved, predicted, friction.fit_for(name)))
    return [*observability(errors), *at_rest(friction.fit)]


class Judged(NamedTuple):
    """The errors of predicted currents on a recording, by the speed of the joints.

    speed: |q̇| (n, 6) [rad/s]; of_band: |error| / half-width of the 95 % band (n, 6).
    """

    speed: Array
    of_band: Array


def judged(motion: Motion, currents: Currents, fit: CurrentFit) -> Judged:
    """Return the speeds and errors of predicted currents on a contact-free recording, the errors as
    |τ_ext / k| / half-width of the band.

    fit: without the recording's path, with torque constants k; τ_ext / k is the current's error.
    """
    every = max(1, round(INDEPENDENT_STEP / motion.period))
    torque, stated = currents.external_torque, currents.band
    assert torque is not None
    assert stated is not None
    torque, qd, stated = torque[::every], motion.motor_qd[::every], stated[::every]
    known = finite_rows(torque) & finite_rows(qd)
    of_band = np.abs(torque[known] / torque_constants(fit)) / stated[known]
    return Judged(np.abs(qd[known]), of_band)


def observability(errors: Sequence[Judged]) -> Iterator[Observed]:
    """Yield for each joint the shares in the band by speed, the speeds at which these suffice, and
    the multiple of the band that contains 95 % of its errors at rest.
    """
    if errors:
        speed, of_band = (np.concatenate(part) for part in zip(*errors, strict=True))
        known = np.isfinite(of_band).T
        shares = [share_by_speed(speed[k, j], of_band[k, j] <= 1) for j, k in enumerate(known)]
        for joint, share in enumerate(shares, start=1):
            yield from _shares(joint, share)
        for joint, share in enumerate(shares, start=1):
            yield _predicted(joint, *share.suffices())
        for joint in range(speed.shape[1]):
            resting = speed[:, joint] < SPEED_BINS[1]
            yield from _factor_at_rest(joint + 1, of_band[resting, joint])


def at_rest(fit: CurrentFit) -> Iterator[Observed]:
    """Yield, by joint, the ratio of the width of the 95 % band at rest to that in motion."""
    for number, joint in enumerate(fit.joints, start=1):
        yield Observed(
            quantity="band_at_rest",
            joint=number,
            speed_low=0.0,
            speed_high=0.0,
            speed_unit="rad/s",
            value=joint.band_standing / joint.band_moving if joint.band_moving else np.nan,
            unit="1",
        )


def _shares(joint: int, shares: ShareBySpeed) -> Iterator[Observed]:
    for low, high, share, samples in shares.rows():
        yield Observed(
            quantity="friction_in_band",
            joint=joint,
            speed_low=low,
            speed_high=high,
            speed_unit="rad/s",
            value=share,
            unit="1",
            samples=samples,
        )


def _factor_at_rest(joint: int, of_band: Array) -> Iterator[Observed]:
    """Yield the multiple of the band that contains 95 % of a resting joint's errors, if there are
    MIN_SAMPLES; of_band: |error| / half-width of the band.
    """
    known = of_band[np.isfinite(of_band)]
    if known.size >= MIN_SAMPLES:
        yield Observed(
            quantity="rest_band_factor",
            joint=joint,
            speed_low=0.0,
            speed_high=SPEED_BINS[1],
            speed_unit="rad/s",
            value=float(np.quantile(known, BAND_COVERAGE)),
            unit="1",
            samples=known.size,
        )


def _predicted(joint: int, low: float, high: float) -> Observed:
    """Return the range of speeds in which the stated band of a joint suffices."""
    return Observed(
        quantity="least_velocity",
        joint=joint,
        speed_low=low,
        speed_high=high,
        speed_unit="rad/s",
        value=low,
        unit="rad/s",
    )
