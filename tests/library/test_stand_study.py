"""What simulated recordings tell, and whether intervals hold the truth."""

from pathlib import Path

import pandas as pd
import pytest
import torch

from benchmarks.stand_seeds import Taken, device_rows, fitted_map, map_rows, plans, taken

pytestmark = pytest.mark.slow

torch.set_num_threads(1)

SEEDS = 3  # `benchmarks/stand_seeds.py` counts over 20
FRICTION = ["torque_constant", "offset", "coulomb", "viscous", "load"]


@pytest.fixture(scope="module")
def studies(tmp_path_factory: pytest.TempPathFactory) -> list[list[Taken]]:
    return [
        [taken(plan, tmp_path_factory.mktemp("made")) for plan in plans(seed, seconds=14)[:3]]
        for seed in range(SEEDS)
    ]


@pytest.fixture(scope="module")
def rows(studies: list[list[Taken]]) -> pd.DataFrame:
    return pd.DataFrame([row for study in studies for row in device_rows(study)])


@pytest.fixture(scope="module")
def friction(studies: list[list[Taken]]) -> pd.DataFrame:
    rows = [row for own in studies for row in map_rows(fitted_map(own), own[0].summary)]
    return pd.DataFrame(rows)


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


@pytest.mark.parametrize("quantity", FRICTION)
def test_stated_intervals_hold_the_friction(friction: pd.DataFrame, quantity: str) -> None:
    part = friction[friction["quantity"] == quantity]
    assert len(part) == 3 * 6
    assert (part["within95"] == "yes").mean() >= 0.85


def test_torque_constants_are_not_missed_in_one_direction(tmp_path: Path) -> None:
    """Without noise. Were friction to turn at once, joint 3's would be 3 % too large, and those of
    joints 5 and 6 by 15 and 20 %. Joint 1's is 1.4 % too small, instead of 0.3 %: what real arms
    show at rest, and the stand does not, hides that its friction is periodic.
    """
    drawn = enumerate(plans(seed=0, seconds=14)[:3])
    study = [taken(plan | {"noise": False}, tmp_path / str(k)) for k, plan in drawn]
    rows = pd.DataFrame(map_rows(fitted_map(study), study[0].summary))
    part = rows[rows["quantity"] == "torque_constant"]
    error = (part["estimate"] / part["truth"] - 1).abs()
    assert error.iloc[0] < 0.02
    assert error.iloc[1:4].max() < 0.01
    assert error.iloc[4:].max() < 0.04
