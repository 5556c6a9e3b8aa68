"""What simulated recordings tell of clocks, rotors and the IMU, and whether bands hold it."""

import pandas as pd
import pytest
import torch

from benchmarks.stand_seeds import recovered

torch.set_num_threads(1)

SEEDS = 5  # `benchmarks/stand_seeds.py` counts over 20


@pytest.fixture(scope="module")
def rows() -> pd.DataFrame:
    return pd.DataFrame([row for seed in range(SEEDS) for row in recovered(seed, seconds=14)])


@pytest.mark.parametrize(
    ("quantity", "largest"),
    [
        ("clock_offset", 0.005),
        ("clock_drift", 100.0),
        ("rotor_inertia", 1e-5),
        ("imu_mounting", 5e-4),
        ("imu_tilt", 5e-4),
        ("imu_gyroscope_bias", 5e-4),
    ],
)
def test_stated_intervals_hold_the_truth(rows: pd.DataFrame, quantity: str, largest: float) -> None:
    """Nine in ten over 20 seeds; three in four of as few as these, none far off."""
    part = rows[rows["quantity"] == quantity]
    assert (part["estimate"] - part["truth"]).abs().max() < largest
    assert (part["within95"] == "yes").mean() >= 0.75
