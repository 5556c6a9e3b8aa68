"""Bands of the end effector's acceleration, from the other recordings."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tests.made_tables import table
from ur5lib.judging.acceleration_bands import acceleration_bands
from ur5lib.records.acceleration_errors import AccelerationBand
from ur5lib.records.accelerations import ImuComparison
from ur5lib.smoothing.beside_imu import by_range
from ur5lib.timeseries.arrays import Array

SAMPLES = 20_000


def of_noise(deviation: float, seed: int) -> ImuComparison:
    """A recording whose difference is white: twice as large in motion, three times above 5 Hz."""
    random = np.random.default_rng(seed)
    slow, quick = random.normal(size=(2, SAMPLES, 6))
    moving = (np.arange(SAMPLES) < SAMPLES // 2)[:, None]
    scale = deviation * np.where(moving, 2, 1)
    slow, quick = scale * slow, 3 * scale * quick
    slow[100], quick[101] = np.nan, np.nan

    def differences(cutoff: float) -> dict[str, Array]:
        difference = slow + quick if cutoff > 5 else slow
        return {"ranges": difference, "plain_ranges": 2 * difference}

    return ImuComparison(**by_range(differences, np.where(moving, 0.5, 0.0) * np.ones(6)))


def bands(own: ImuComparison, *others: ImuComparison) -> pd.DataFrame:
    """Rows of the first recording, calibrated on all."""
    every = {str(k): summary for k, summary in enumerate((own, *others))}
    calibrated = {name: replace(summary, calibrated_on=[*every]) for name, summary in every.items()}
    return table(AccelerationBand, {"0": acceleration_bands(calibrated["0"], calibrated)})


def test_a_band_is_that_of_the_other_recordings() -> None:
    others = [of_noise(0.1, seed) for seed in (1, 2)]
    rows = bands(of_noise(0.1, 3), *others)
    assert len(rows) == 3 * 2 * 6
    for _, row in rows.iterrows():
        size = 0.1 * (2 if row["during"] == "motion" else 1)
        size *= 3 if row["range"] == "5 to 20 Hz" else 1
        assert row["rms"] == pytest.approx(size, rel=0.05)
        assert row["std"] == pytest.approx(size, rel=0.05)
        assert row["held"] == pytest.approx(0.95, abs=0.015)
        assert row["filterpy_rms"] == pytest.approx(2 * row["rms"])
    narrow = bands(of_noise(0.2, 3), *others)
    assert all(held == pytest.approx(0.673, abs=0.03) for held in narrow["held"])


def test_a_recording_alone_has_no_band() -> None:
    assert bands(of_noise(0.1, 1)).empty
    assert bands(ImuComparison(), of_noise(0.1, 1)).empty
