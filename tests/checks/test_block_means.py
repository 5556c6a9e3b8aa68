"""Means over blocks, and what regressions on them give, by other ways."""

import numpy as np
import pandas as pd
import pytest

from ur5lib.checks.block_means import (
    BlockMeans,
    block_means,
    combination,
    fitted_load,
)
from ur5lib.timeseries.arrays import Array

PERIOD, COUNT, LENGTH = 0.02, 100, 5  # s, rows, rows of a block of a tenth of a second
TIME = PERIOD * np.arange(COUNT)
RANDOM = np.random.default_rng(3)


def table(**channels: Array) -> pd.DataFrame:
    columns = {f"{name}_{j}": values[:, j] for name, values in channels.items() for j in range(6)}
    about = {"time": 5.0 + TIME, "segment": 0, "interpolated": False}
    return pd.DataFrame(about | columns)


@pytest.fixture
def robot() -> pd.DataFrame:
    """Joints that begin at 0.1 rad/s and accelerate by 1 to 6 rad/s²."""
    rates = np.arange(1.0, 7.0)
    q = 0.1 * TIME[:, None] + 0.5 * rates * TIME[:, None] ** 2
    current = RANDOM.normal(size=(COUNT, 6))
    return table(actual_q=q, actual_qd=0.1 + TIME[:, None] * rates, actual_current=current)


def blocks_of(values: Array) -> Array:
    return np.array([values[k : k + LENGTH].mean(axis=0) for k in range(0, len(values), LENGTH)])


def test_each_block_has_the_means_of_its_rows(robot: pd.DataFrame) -> None:
    means = block_means(robot, PERIOD)
    for name, found in (
        ("actual_q", means.q),
        ("actual_qd", means.qd),
        ("actual_current", means.effort),
    ):
        values = robot[[f"{name}_{j}" for j in range(6)]].to_numpy()
        np.testing.assert_allclose(found, blocks_of(values))
    np.testing.assert_allclose(means.qdd, np.tile(np.arange(1.0, 7.0), (20, 1)))
    assert means.time is not None
    np.testing.assert_allclose(means.time, 5.0 + TIME[::LENGTH])
    assert means.torque is None
    assert not means.offset
    assert means.independent == pytest.approx(1 / 4)  # errors last for four blocks


def test_velocities_that_were_not_recorded_are_those_of_the_positions(robot: pd.DataFrame) -> None:
    without = robot.drop(columns=[f"actual_qd_{j}" for j in range(6)])
    inside = slice(1, -1)  # the ends have one side alone
    np.testing.assert_allclose(
        block_means(without, PERIOD).qd[inside], block_means(robot, PERIOD).qd[inside]
    )


def test_a_block_that_is_torn_unknown_or_hardly_received_is_left_out(robot: pd.DataFrame) -> None:
    """Three of five filled frames are few enough."""
    robot.loc[7, "actual_current_3"] = np.nan  # second block
    robot.loc[13:, "segment"] = 1  # third
    robot.loc[20:23, "interpolated"] = True  # fifth: four frames
    robot.loc[25:27, "interpolated"] = True  # sixth: three
    means = block_means(robot, PERIOD)
    assert means.time is not None
    assert means.segment is not None
    kept = [k for k in range(20) if k not in (1, 2, 4)]
    np.testing.assert_allclose(means.time, 5.0 + TIME[::LENGTH][kept])
    np.testing.assert_array_equal(means.segment, [0, *[1] * 16])


def test_a_slow_recording_has_blocks_of_three_rows(robot: pd.DataFrame) -> None:
    assert len(block_means(robot, 0.05).q) == COUNT // 3


def made(count: int = 60, **more: Array) -> BlockMeans:
    q, qd, qdd, current = RANDOM.normal(size=(4, count, 6))
    given = {"q": q, "qd": qd, "qdd": qdd} | more
    return BlockMeans(**given, torque=None, currents={"actual_current": current})


def test_a_weighted_sum_of_coefficients_has_the_error_of_least_squares() -> None:
    """Of errors that last for four blocks: twice that of independent ones."""
    columns, truth = RANDOM.normal(size=(400, 3)), np.array([1.0, -2.0, 0.5])
    weights = np.array([2.0, 1.0])
    sums, errors = zip(
        *(
            combination(columns, columns @ truth + RANDOM.normal(size=400), weights)
            for _ in range(300)
        ),
        strict=True,
    )
    assert np.mean(sums) == pytest.approx(0.0, abs=0.02)
    assert np.mean(errors) == pytest.approx(2 * np.std(sums), rel=0.1)


def test_a_load_is_found_with_its_center_and_without_what_nothing_determines() -> None:
    columns = RANDOM.normal(size=(50, 4))
    mass, left = fitted_load(columns, columns @ [2.0, 0.1, -0.2, 0.3])
    assert mass == pytest.approx(2.0, abs=1e-3)
    assert left < 1e-2
    noise = RANDOM.normal(size=50)
    _, left = fitted_load(columns, noise)
    best = noise - columns @ np.linalg.lstsq(columns, noise, rcond=None)[0]
    assert left == pytest.approx(np.linalg.norm(best), rel=1e-3)
    columns[:, 1:] *= 1e-6  # no first moment shows
    mass, left = fitted_load(columns, columns @ [2.0, 1.0, 1.0, 1.0])
    assert mass == pytest.approx(2.0, abs=1e-3)


def test_what_is_left_beside_inertia_follows_from_no_acceleration() -> None:
    means, torque = made(), RANDOM.normal(size=(60, 6))
    left = means.beside_inertia(torque + 3.0 * means.qdd)
    np.testing.assert_allclose(means.qdd.T @ left, 0.0, atol=1e-9)
    np.testing.assert_allclose(left, means.beside_inertia(torque), atol=1e-9)


def test_a_fourth_of_the_blocks_is_evidence() -> None:
    """Half a logarithm of the mean square for each."""
    gained = made(80).log_likelihood(np.array([1.0])) - made(80).log_likelihood(np.array([np.e]))
    assert gained == pytest.approx(80 / 4 / 2)


def test_friction_is_full_in_motion_and_odd() -> None:
    qd = np.zeros((4, 6))
    qd[:, 2] = [-1.0, -0.02, 0.0, 0.5]
    np.testing.assert_allclose(
        made(4, qd=qd).friction(2), [[-1, -1], [-np.tanh(1), -0.02], [0, 0], [1, 0.5]], atol=1e-9
    )


@pytest.mark.parametrize(("fast", "shown"), [(19, 60), (20, 20)])
def test_blocks_in_motion_show_a_slope_if_there_are_twenty(fast: int, shown: int) -> None:
    qd = np.full((60, 6), 0.019)
    qd[:fast, 1] = -0.021
    assert made(qd=qd).rubbing(1).sum() == shown


def test_joints_move_alike_if_their_velocities_are_proportional() -> None:
    qd = RANDOM.normal(size=(60, 6))
    qd[:, 4], qd[:, 3] = -2.0 * qd[:, 1], 0.0
    qd[:, 5] = qd[:, 1] + 0.3 * qd[:, 2] * np.linalg.norm(qd[:, 1]) / np.linalg.norm(qd[:, 2])
    means = made(qd=qd)
    found = {pair for pair in ((1, 4), (1, 2), (1, 3), (1, 5)) if means.move_alike(pair)}
    assert found == {(1, 4)}


def test_an_effort_has_columns_beside_gravity() -> None:
    means = made()
    assert means.without_gravity(0, means.qdd).shape == (60, 2 + 6)
    several = BlockMeans(means.q, means.qd, means.qdd, None, means.currents, offset=True)
    np.testing.assert_array_equal(several.without_gravity(0, means.qdd)[:, -1], 1.0)
