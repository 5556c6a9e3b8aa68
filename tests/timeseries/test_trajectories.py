"""Runs of one trajectory are one sample of the world."""

import numpy as np
import pytest

from ur5lib.timeseries.trajectories import (
    POSITION_TOLERANCE,
    PathStates,
    group_by_path,
    nearest,
    scaled_states,
)

PERIOD = 0.02
Motion = tuple[np.ndarray, np.ndarray]


def wave(seed: int, start: float = 0.0, seconds: float = 20.0, off: float = 0.0) -> Motion:
    """Position and velocity of one of many motions, from a time on; off: [rad], of all joints."""
    random = np.random.default_rng(seed)
    pace, phase = random.uniform(0.3, 1.2, 6), random.uniform(0, 6, 6)
    time = np.arange(start, start + seconds, PERIOD)[:, None]
    angle = pace * time + phase
    return 0.8 * np.sin(angle) + off, 0.8 * pace * np.cos(angle)


def rest(pose: np.ndarray, seconds: float = 5.0) -> Motion:
    count = round(seconds / PERIOD)
    return np.tile(pose, (count, 1)), np.zeros((count, 6))


def joined(*motions: Motion) -> Motion:
    q, qd = (np.concatenate(parts) for parts in zip(*motions, strict=True))
    return q, qd


def labels(*motions: Motion) -> list[int]:
    return group_by_path([PathStates.from_motion(*motion) for motion in motions]).tolist()


def test_a_repeated_run_is_of_one_path_though_it_starts_elsewhere_in_time() -> None:
    """Samples fall between the other's, and encoders are not exact."""
    random = np.random.default_rng(0)
    q, qd = wave(0, start=0.007)
    again = q + 1e-4 * random.normal(size=q.shape), qd + 1e-3 * random.normal(size=q.shape)
    assert labels(wave(0), wave(1), again) == [0, 1, 0]


@pytest.mark.parametrize("start", [0.004, 0.05])
def test_fast_runs_of_one_trajectory_are_known_as_one(start: float) -> None:
    """At 3 rad/s a joint goes far beyond what is near between samples that are thinned."""

    def fast(start: float, seconds: float = 6.0) -> PathStates:
        time = np.arange(start, start + seconds, 0.008)[:, None]
        angle = 4 * time + np.arange(6)
        return PathStates.from_motion(0.8 * np.sin(angle), 3.2 * np.cos(angle), stride=12)

    slow = PathStates.from_motion(*wave(0), stride=5)
    runs = [fast(0.0), slow, fast(start), fast(start, seconds=2.0)]
    assert group_by_path(runs).tolist() == [0, 1, 0, 0]


Q, QD = wave(0)
KNOWN = np.isin(np.arange(len(Q)), range(100, 400), invert=True)[:, None]
HOME, POSE = np.zeros(6), np.full(6, 0.3)
WAIT = rest(HOME, seconds=60.0)
PART, LATER = wave(0, seconds=8.0), wave(0, start=10.0, seconds=8.0)
RUNS = {  # and their labels: those of the first of each, from 0 on without a hole
    "none": ([], []),
    "repeated in turn": ([wave(seed) for seed in (3, 1, 3, 2, 1, 3)], [0, 1, 0, 2, 1, 0]),
    "the whole, then a part": ([wave(0), LATER], [0, 0]),
    "two parts": ([PART, LATER], [0, 1]),
    "two parts, then the whole": ([PART, LATER, wave(0)], [0, 0, 0]),
    "the whole between its parts": ([PART, wave(0), LATER, wave(1)], [0, 0, 0, 1]),
    "half in common": (
        [joined(wave(0, seconds=10.0), wave(seed, seconds=10.0)) for seed in (1, 2)],
        [0, 1],
    ),
    "the way back, with another friction": ([(Q, QD), (Q[::-1], -QD[::-1])], [0, 1]),
    "another speed": ([(Q, QD), (Q[::2], 2 * QD[::2])], [0, 1]),
    "moves that wait long at one pose": (
        [*(joined(WAIT, wave(seed, seconds=5.0), WAIT) for seed in (0, 1)), rest(HOME)],
        [0, 1, 2],
    ),
    "standstills": ([rest(POSE), rest(POSE, seconds=9.0), rest(POSE + 0.1)], [0, 0, 1]),
    "rows unknown": ([(np.where(KNOWN, Q, np.nan), QD), (Q, QD)], [0, 0]),
    "all unknown": ([(Q * np.nan, QD), (Q, QD), (Q, QD * np.nan)], [0, 1, 2]),
}


@pytest.mark.parametrize("case", RUNS)
def test_runs_are_grouped_by_trajectory(case: str) -> None:
    motions, expected = RUNS[case]
    assert labels(*motions) == expected


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_near_is_within_the_stated_distance(share: float) -> None:
    q = np.zeros((1, 6))
    other = q + share * POSITION_TOLERANCE * np.eye(6)[:1]
    near, index = nearest(
        scaled_states(other, q), scaled_states(np.array([[9.0] * 6, [0.0] * 6]), np.zeros((2, 6)))
    )
    assert near.tolist() == [share < 1]
    assert not near[0] or index.tolist() == [1]


def test_thousands_of_repetitions_take_one_comparison_each() -> None:
    """Runs are read one by one, and only those that are no part of an earlier one are kept."""
    programs = [wave(seed, seconds=4.0) for seed in range(3)]
    asked = list[int]()

    class Counted(PathStates):
        def within(self, other: PathStates) -> float:
            asked.append(1)
            return super().within(other)

    runs = (Counted.from_motion(*programs[k % 3], stride=5) for k in range(300))
    assert group_by_path(runs).tolist() == [0, 1, 2] * 100
    assert len(asked) < 310
