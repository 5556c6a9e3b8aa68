"""Runs of one trajectory are one sample of the world."""

import numpy as np
import pytest

from ur5lib.timeseries.trajectories import NEAR_POSITION, PathStates, group_by_path, nearest, place

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
        return PathStates.from_motion(0.8 * np.sin(angle), 3.2 * np.cos(angle), every=12)

    slow = PathStates.from_motion(*wave(0), every=5)
    runs = [fast(0.0), slow, fast(start), fast(start, seconds=2.0)]
    assert group_by_path(runs).tolist() == [0, 1, 0, 0]


def test_a_part_of_a_longer_run_is_of_its_trajectory() -> None:
    whole, part = wave(0), wave(0, start=8.0, seconds=5.0)
    assert labels(whole, part) == labels(part, whole) == [0, 0]


def test_two_parts_belong_together_by_way_of_the_whole() -> None:
    """Neither passes the other, both pass the third, in whichever order they come."""
    parts = wave(0, seconds=8.0), wave(0, start=10.0, seconds=8.0)
    assert labels(*parts) == [0, 1]
    assert labels(*parts, wave(0)) == [0, 0, 0]
    assert labels(parts[0], wave(0), parts[1], wave(1)) == [0, 0, 0, 1]


def test_half_a_run_in_common_is_not_the_same() -> None:
    one = joined(wave(0, seconds=10.0), wave(1, seconds=10.0))
    other = joined(wave(0, seconds=10.0), wave(2, seconds=10.0))
    assert labels(one, other) == [0, 1]


def test_the_way_back_is_another_trajectory() -> None:
    """The same places at the opposite velocity: friction is another."""
    q, qd = wave(0)
    assert labels((q, qd), (q[::-1], -qd[::-1])) == [0, 1]


def test_another_speed_is_another_trajectory() -> None:
    q, qd = wave(0)
    assert labels((q, qd), (q[::2], 2 * qd[::2])) == [0, 1]


def test_a_pose_where_others_stop_does_not_make_them_one() -> None:
    """Two short motions that wait long at home, and a standstill there: three, not one."""
    home = np.zeros(6)
    wait = rest(home, seconds=60.0)
    moves = [joined(wait, wave(seed, seconds=5.0), wait) for seed in (0, 1)]
    assert labels(*moves, rest(home)) == [0, 1, 2]


def test_a_standstill_is_the_same_as_another_at_its_pose() -> None:
    pose = np.full(6, 0.3)
    assert labels(rest(pose), rest(pose, seconds=9.0), rest(pose + 0.1)) == [0, 0, 1]


def test_rows_that_are_unknown_are_left_out() -> None:
    q, qd = (values.copy() for values in wave(0))
    q[100:300], qd[250:400] = np.nan, np.nan
    assert labels((q, qd), wave(0)) == [0, 0]
    nothing = np.full_like(q, np.nan)
    assert labels((nothing, nothing), wave(0), (nothing, nothing)) == [0, 1, 2]


def test_labels_are_those_of_the_first_of_each() -> None:
    """From 0 on without a hole, however runs are ordered."""
    runs = [wave(seed) for seed in (3, 1, 3, 2, 1, 3)]
    found = labels(*runs)
    assert sorted(set(found)) == [0, 1, 2]
    assert [found[k] == found[0] for k in range(6)] == [True, False, True, False, False, True]
    assert (labels(), labels(wave(0))) == ([], [0])


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_near_is_within_the_stated_distance(share: float) -> None:
    q = np.zeros((1, 6))
    other = q + share * NEAR_POSITION * np.eye(6)[:1]
    near, index = nearest(
        place(other, q), place(np.array([[9.0] * 6, [0.0] * 6]), np.zeros((2, 6)))
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

    runs = (Counted.from_motion(*programs[k % 3], every=5) for k in range(300))
    assert group_by_path(runs).tolist() == [0, 1, 2] * 100
    assert len(asked) < 310
