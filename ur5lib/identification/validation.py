"""Errors of predicted currents: baselines, cross-validation, and errors by speed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise

import numpy as np

from ur5lib.identification.joint_regression import (
    MIN_SAMPLES,
    left_out_residuals,
    regress_samples,
)
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import (
    CurrentSamples,
    MotionState,
    Smooth,
    joint_samples,
    motion_states,
)
from ur5lib.identification.selection import MIN_DEVIATIONS, MIN_SHARE, is_less
from ur5lib.records.prediction import Scores
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import BAND_COVERAGE, finite_quantile
from ur5lib.timeseries.segments import DEAD_ZONE, in_chunks

SPEED_BINS = np.array([0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, np.inf])  # rad/s
ROTOR = "rotor"  # the term of a joint's rotor
FOLDS = 10  # paths, or parts of one, form this many folds
MIN_SHARE_IN_BAND = 0.9  # a 95 % band suffices if it contains this share of a bin's samples


def coefficients_of_constants(
    torque_constant: Array, offset: Array, coulomb: Array, viscous: Array
) -> Array:
    """Return coefficients (6, 4) for `baseline_current` from constants (6,) such as the thesis's.

    torque_constant [Nm/A], offset [Nm] (Equation 6.6); coulomb [Nm], viscous [Nm s/rad] (6.2).
    """
    torques = np.stack([np.ones_like(offset), -offset, coulomb, viscous], axis=1)
    return torques / torque_constant[:, None]


def least_squares_coefficients(records: Sequence[CurrentSamples]) -> Array:
    """Return coefficients (n, 4) fitted by plain least squares to all samples, as a baseline."""
    columns = np.concatenate([_baseline_columns(record.torque, record.qd) for record in records])
    current = np.concatenate([record.current for record in records])
    finite = np.isfinite(columns).all(axis=(1, 2)) & np.isfinite(current).all(axis=1)
    joints = zip(columns[finite].swapaxes(0, 1), current[finite].T, strict=True)
    return np.stack([np.linalg.lstsq(*joint)[0] for joint in joints])


def baseline_current(record: CurrentSamples, coefficients: Array) -> Array:
    """Return the current (N, 6) [A] that Equation 6.4 predicts with Coulomb and viscous friction.

    coefficients: (6, 4) of torque [A/Nm], offset [A], direction [A] and velocity [A s/rad].
    """
    return in_chunks(
        lambda torque, qd: (_baseline_columns(torque, qd) * coefficients).sum(axis=2),
        record.torque,
        record.qd,
    )


def score(record: CurrentSamples, predicted: Array, smooth: Smooth, half_band: Array) -> Scores:
    """Return the errors of a predicted current (N, n) [A]; half_band: (N, n) [A], of the low-passed
    current.
    """
    error = record.current - predicted
    slow = smooth(error, record)
    measured = smooth(record.current, record)
    of_band = np.abs(slow) / np.where(half_band > 0, half_band, np.nan)
    inside = np.where(np.isfinite(of_band), of_band <= 1.0, np.nan)
    before = motion_states(record, smooth) == MotionState.UNKNOWN
    return Scores(
        rmse=np.sqrt(_mean(error**2)),
        rmse_lowpassed=np.sqrt(_mean(slow**2)),
        mae=_mean(np.abs(slow)),
        # the share of the low-passed variance that is explained
        r2=1 - _mean(slow**2) / np.nanvar(measured, axis=0),
        coverage=_mean(inside),
        band_factor95=finite_quantile(of_band, BAND_COVERAGE),
        rmse_before_motion=np.sqrt(_mean(np.where(before, slow**2, np.nan))),
        coverage_before_motion=_mean(np.where(before, inside, np.nan)),
    )


def explained_share(
    records: Sequence[CurrentSamples], predicted: Sequence[Array], smooth: Smooth
) -> Array:
    """Return the share (n,) of the low-passed currents' variance that predictions explain.

    1 - Σ (i - î)² / Σ (i - ī)² over the samples of all recordings, ī their mean: negative where a
    constant current is nearer. predicted: (N, n) [A] each.
    """
    measured = np.concatenate([smooth(record.current, record) for record in records])
    pairs = zip(records, predicted, strict=True)
    error = np.concatenate(
        [smooth(record.current - prediction, record) for record, prediction in pairs]
    )
    measured_rows = np.where(np.isfinite(error), measured, np.nan)
    return 1 - _mean(error**2) / np.nanvar(measured_rows, axis=0)


def fitted_on_tested_on(records: Sequence[CurrentSamples], smooth: Smooth, prior: Prior) -> Array:
    """Return the RMSE [A] in motion, (R, R, n), of fits to recording i on recording j.

    NaN if a joint does not move in both.
    """
    table = np.full((len(records), len(records), len(prior.torque_max)), np.nan)
    for joint, samples in enumerate(joint_samples(records, smooth, prior.terms)):
        moving = samples.where(samples.moving)
        for fitted in np.unique(moving.record):
            one_recording = moving.where(moving.record == fitted)
            fit = regress_samples(one_recording, prior.of_joint(joint))
            error = (moving.current - moving.columns @ fit.coefficients) ** 2
            for tested in np.unique(moving.record):
                table[fitted, tested, joint] = np.sqrt(error[moving.record == tested].mean())
    return table


def with_rotors_that_show(
    records: Sequence[CurrentSamples], smooth: Smooth, prior: Prior
) -> list[CurrentSamples]:
    """Return recordings without the accelerations of joints on which no rotor shows, so that none
    is fitted there.

    A rotor shows where it surely reduces errors on left-out paths, or parts in time if paths are
    few: sensors behind the gears feel none.
    """
    if ROTOR not in prior.terms:
        return [*records]
    trial = _unseen_errors(records, smooth, prior)
    without = [replace(record, qdd=None) for record in records]
    errors = _unseen_errors(without, smooth, prior)
    limits, pairs = (MIN_SHARE, MIN_DEVIATIONS), zip(trial.T, errors.T, strict=True)
    shows = [is_less(*pair, *limits) for pair in pairs]
    return [
        replace(record, qdd=record.qdd * shows) if any(shows) and record.qdd is not None else bare
        for record, bare in zip(records, without, strict=True)
    ]


def _unseen_errors(records: Sequence[CurrentSamples], smooth: Smooth, prior: Prior) -> Array:
    """Return the squared errors Σ r² (F, n) in motion of left-out folds of paths, or of parts of
    recordings if paths are few.
    """
    errors = np.zeros((FOLDS, len(prior.torque_max)))
    for joint, samples in enumerate(joint_samples(records, smooth, prior.terms)):
        moving = samples.where(samples.moving)
        part = np.arange(len(moving.current)) * FOLDS // max(1, len(moving.current))
        fold = part if len(np.unique(moving.path)) < FOLDS else moving.path % FOLDS
        residual = left_out_residuals(replace(moving, path=fold), prior.of_joint(joint))
        errors[:, joint] = np.bincount(fold, residual**2, FOLDS)
    return errors


def _baseline_columns(torque: Array, qd: Array) -> Array:
    """Return the baseline's columns (N, 6, 4): torque, one, direction, velocity."""
    direction = np.where(np.abs(qd) > DEAD_ZONE, np.sign(qd), 0.0)
    return np.stack([torque, np.ones_like(qd), direction, qd], axis=2)


def _mean(values: Array) -> Array:
    """Return the mean of each column's finite values; NaN if there are none."""
    finite = np.isfinite(values)
    count = np.where(finite.any(axis=0), finite.sum(axis=0), np.nan)
    mean: Array = np.where(finite, values, 0.0).sum(axis=0) / count
    return mean


@dataclass(frozen=True)
class ShareBySpeed:
    """How many of a joint's errors are within their band, by speed.

    share: (B,), between the speeds SPEED_BINS, NaN in bins with less than MIN_SAMPLES samples;
    samples: number in each bin (B,).
    """

    share: Array
    samples: Array

    def rows(self) -> Iterator[tuple[float, float, float, float]]:
        """Yield, for each bin, its lowest and highest speed [rad/s], share and number of
        samples.
        """
        for (low, high), *bin_values in zip(
            pairwise(SPEED_BINS), self.share, self.samples, strict=True
        ):
            yield low, high, *bin_values

    def suffices(self) -> tuple[float, float]:
        """Return the speeds [rad/s] between which every bin has MIN_SHARE_IN_BAND or more.

        The upper one is infinite if the fastest bin with a share has it. Of several ranges, the one
        with most samples is taken; NaN without any.
        """
        known_bins = np.flatnonzero(np.isfinite(self.share))
        runs = [
            [int(place) for place in run]
            for enough, run in groupby(
                known_bins, lambda place: self.share[place] >= MIN_SHARE_IN_BAND
            )
            if enough
        ]
        if not runs:
            return np.nan, np.nan
        best = max(runs, key=lambda run: self.samples[run].sum())
        high = np.inf if best[-1] == known_bins[-1] else float(SPEED_BINS[best[-1] + 1])
        return float(SPEED_BINS[best[0]]), high


def share_by_speed(speed: Array, inside: Mask) -> ShareBySpeed:
    """Return the share of samples within their band by speed; speed: (N,) [rad/s]; inside: whether
    each is within (N,).
    """
    place, count = np.digitize(speed, SPEED_BINS) - 1, len(SPEED_BINS) - 1
    samples = np.bincount(place, minlength=count)
    inside_count = np.bincount(place, weights=inside, minlength=count)
    share = np.where(samples >= MIN_SAMPLES, inside_count / np.maximum(samples, 1), np.nan)
    return ShareBySpeed(share, samples.astype(np.float64))
