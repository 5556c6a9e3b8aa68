"""Scores of a predicted current, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from tests.library.current_study import PRESLIDING, make_record, prior, smooth
from ur5lib.identification.samples import Record
from ur5lib.identification.validation import (
    fitted_on_tested_on,
    least_squares_coefficients,
    score,
)
from ur5lib.robots.friction import BASE
from ur5lib.timeseries.arrays import Array


def halved(values: Array, _: Record) -> Array:
    """Stands for a low-pass: of errors it leaves a half."""
    return values / 2


def test_scores_are_means_over_what_is_known() -> None:
    record = make_record(0, seconds=2.0)
    error = np.tile([0.4, -0.2], 50)[:, None] * np.arange(1.0, 7.0)
    error[:10, 1] = np.nan
    error[:, 5] = np.nan
    half_band = np.full_like(error, 0.15)
    half_band[50:, 2] = np.nan
    scores = score(record, record.current - error, halved, half_band)
    known = np.arange(1.0, 6.0)
    np.testing.assert_allclose(scores.rmse[:5], known * np.sqrt(0.1))
    np.testing.assert_allclose(scores.rmse_lowpassed[:5], known * np.sqrt(0.1) / 2)
    np.testing.assert_allclose(scores.mae[:5], known * 0.15)
    variance = (record.current[:, :5] / 2).var(axis=0)
    np.testing.assert_allclose(scores.r2[:5], 1 - 0.025 * known**2 / variance)
    np.testing.assert_allclose(scores.coverage, [0.5, 0, 0, 0, 0, np.nan])
    for values in (scores.rmse, scores.mae, scores.r2):
        assert np.isnan(values[5])


def test_the_edge_of_a_band_is_inside() -> None:
    record = make_record(0, seconds=1.0)
    error = np.full_like(record.current, 0.5)
    for band, share in ((0.25, 1.0), (0.2499, 0.0)):
        scores = score(record, record.current - error, halved, np.full_like(error, band))
        np.testing.assert_allclose(scores.coverage, share)


def test_a_fit_is_tested_where_both_recordings_move() -> None:
    """Of an exact map without noise nothing is left; a joint that rests has no score."""
    records = [make_record(seed) for seed in range(2)]
    resting = replace(
        records[1],
        q=records[1].q * [1, 1, 1, 1, 0, 1],
        qd=records[1].qd * [1, 1, 1, 1, 0, 1],
    )
    table = fitted_on_tested_on(
        [records[0], resting], smooth, prior(), [BASE] * 6, [PRESLIDING] * 6
    )
    assert np.isnan(table[:, 1, 4]).all()
    assert np.isnan(table[1, :, 4]).all()
    assert table[0, 0, 4] < 0.01
    assert np.nanmax(table[:, :, [0, 1, 3]]) < 0.02
    assert (table[0, :, 2] > 0.02).all()  # a term that is not fitted
    assert table[0, 1, 2] == pytest.approx(table[0, 0, 2], rel=1.0)


def test_a_fit_is_tested_on_each_sample_of_the_other_recording() -> None:
    """One has 0.3 A more for 2 s and 0.3 A less for 2 s, in turn, which no term explains."""
    plain, changed = make_record(0), make_record(1)
    wave = np.where(np.arange(len(changed.q)) // 100 % 2, 0.3, -0.3)
    changed = replace(changed, current=changed.current + wave[:, None])
    table = fitted_on_tested_on([plain, changed], smooth, prior(), [BASE] * 6, [PRESLIDING] * 6)
    exact = [0, 1, 3, 4, 5]  # of joint 3, a term is not fitted
    np.testing.assert_allclose(table[0, 1, exact], 0.3, rtol=0.1)
    assert (table[1, 0, exact] < 0.2).all()


def test_the_baseline_is_fitted_to_the_samples_that_are_whole() -> None:
    """A cell that is missing takes its sample along, and no other."""
    record = make_record(0)
    lacking = replace(record, torque=record.torque.copy(), current=record.current.copy())
    lacking.torque[:50, 2] = np.nan
    lacking.current[100:150, 4] = np.nan
    whole = np.ones(len(record.q), bool)
    whole[:50] = whole[100:150] = False
    parts = {name: getattr(record, name)[whole] for name in ("torque", "qd", "current")}
    np.testing.assert_allclose(
        least_squares_coefficients([lacking]),
        least_squares_coefficients([replace(record, **parts)]),
        atol=1e-9,
    )
