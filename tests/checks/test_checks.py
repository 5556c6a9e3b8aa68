"""From which difference on channels contradict one another."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import brentq

from tests.conftest import said
from tests.synthetic import PERIOD, poor_log
from ur5lib.checks.channels import (
    check_robot,
    fast_between_samples,
    no_motion,
    slow_samples,
    too_short,
    unmoved,
    untold_motion,
)
from ur5lib.checks.checked import Checked
from ur5lib.checks.contacts import sensed_contacts
from ur5lib.checks.devices import check_force_sensor, check_imu
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.checks.unchecked import MAX_NAMED, unchecked
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.quality import Finding
from ur5lib.robots.description import FullScale, load_robot, robot_path

CURRENTS = [f"actual_current_{joint}" for joint in range(6)]

LIMITS = [(-6.3, 6.3)] * 6, [3.2] * 6  # rad, rad/s


def found(findings: list[Finding], name: str) -> Finding:
    (finding,) = [finding for finding in findings if finding.code == name]
    return finding


def moving_robot() -> pd.DataFrame:
    """Half a minute of an arm whose joints swing, each at its own pace by its own current."""
    time = np.arange(0, 30, PERIOD)
    pace = np.linspace(0.5, 1.1, 6)
    angle = pace * time[:, None]
    channels = {"q": np.sin(angle), "qd": pace * np.cos(angle), "qdd": -(pace**2) * np.sin(angle)}
    channels["current"] = channels["moment"] = np.linspace(1, 3, 6) * np.cos(2 * angle)
    table = pd.DataFrame({"time": time, "segment": 0, "interpolated": False})
    for name, values in channels.items():
        for joint in range(6):
            table[f"target_{name}_{joint}"] = table[f"actual_{name}_{joint}"] = values[:, joint]
    return table


def contradictions(table: pd.DataFrame) -> list[str]:
    return [said(reported) for reported in check_robot(table, PERIOD, *LIMITS)]


def test_channels_that_agree_are_not_remarked() -> None:
    table = moving_robot()
    assert contradictions(table) == []
    assert contradictions(table.assign(actual_q_0=table["actual_q_0"] + 0.04)) == []
    table["segment"] = (table["time"] > 10).astype(int)  # where it went on elsewhere
    table.loc[table["time"] > 10, ["actual_q_2", "target_q_2"]] += 1
    assert contradictions(table) == []


def test_a_joint_that_never_moved_is_noted() -> None:
    """Since nothing says to which side its friction holds; encoders' noise is no motion."""
    angles = np.sin(np.linspace(0, 3, 100))[:, None] * [1, 1, 1e-4, 1, 0, 1]
    (note,) = unmoved(angles)
    assert (note.severity, note.count) == ("note", 2)
    assert note.detail.startswith("joints 3, 5 never moved")
    assert not any(unmoved(angles[:, [0, 1, 3, 5]]))


def test_a_fit_without_any_motion_is_warned_of() -> None:
    """Before, three postures at rest were a fit of good quality."""
    angles = np.sin(np.linspace(0, 3, 100))[:, None] * [1e-4, 0, 2e-4]
    (warning,) = no_motion(angles)
    assert (warning.severity, warning.count) == ("warning", 3)
    assert not any(no_motion(angles + [0, 0, 1] * angles * 1e4))


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("still", ["actual_q", "actual_qd"])
def test_a_channel_that_keeps_still_is_no_derivative_of_one_that_moves(
    still: str, side: int
) -> None:
    """Though a joint that swings to and fro does not move on the whole."""
    table = moving_robot()
    table[["actual_q_3", "actual_qd_3"]] *= side
    table[f"{still}_3"] = 0.0
    (reported,) = [one for one in contradictions(table) if "not the derivative" in one]
    assert "actual_qd is not the derivative of actual_q " in reported
    assert "joint 4: " in reported


def test_currents_of_two_joints_that_changed_places_are_reported() -> None:
    table = moving_robot()
    pair = ["actual_current_1", "actual_current_4"]
    table[pair] = table[pair[::-1]].to_numpy()
    (reported,) = [one for one in contradictions(table) if "swapped" in one]
    assert "of joint 2 follows target_current of joint 5 and vice versa" in reported


def test_a_current_written_twice_is_no_swap() -> None:
    """One of both joints still follows its own target, and not the other's."""
    table = moving_robot()
    table["actual_current_1"] = table["target_current_4"]
    assert not [one for one in contradictions(table) if "swapped" in one]


def test_twins_that_part_are_told_by_joint() -> None:
    table = moving_robot()
    table["actual_q_4"] += 0.06
    assert contradictions(table) == [
        "actual_q and target_q differ on joint 5; check columns and units"
    ]


def test_limits_are_each_joints_own() -> None:
    table = moving_robot()
    names = ("actual_q_2", "target_q_2")
    for name in names:
        table.loc[:4, name] = -6.5
    turns, speeds = [*LIMITS[0]], LIMITS[1]
    (reported,) = [f for f in check_robot(table, PERIOD, turns, speeds) if f.count == 5]
    assert "(joint 3: up to 6.5 rad)" in said(reported)
    turns[2] = (-6.5, 6.5)  # reached, not exceeded
    assert not [
        f for f in check_robot(table, PERIOD, turns, speeds) if f.code == Found.JOINT_LIMITS
    ]
    turns[2] = (-6.4, 9.0)
    (reported,) = [f for f in check_robot(table, PERIOD, turns, speeds) if f.count == 5]
    assert "(joint 3: up to −6.5 rad)" in said(reported)


@pytest.mark.parametrize("side", [1, -1])
def test_counted_angles_leave_their_range_by_more_than_a_twentieth(side: int) -> None:
    """To either side; a controller lets no joint go there."""
    table = moving_robot()
    for beyond, name in ((0.04, Found.JOINT_LIMITS), (0.06, Found.JOINTS_BEYOND_THEIR_RANGE)):
        table.loc[:4, ["actual_q_2", "target_q_2"]] = side * (6.3 + beyond)
        found = [one for one in check_robot(table, PERIOD, *LIMITS, counted=True) if one.count == 5]
        # within the twentieth it is a note, as of angles that no counts make
        assert [one.code for one in found if "joint" in one.code] == [name] * len(found)
        assert bool(found)


@pytest.mark.parametrize(("count", "reported"), [(9, False), (10, True)])
def test_a_force_that_stays_at_its_extreme_is_saturated(count: int, reported: bool) -> None:
    moving = {name: np.linspace(-20, 30, 100) for name in ("ft_fx", "ft_fy", "ft_fz")}
    table = pd.DataFrame({"time": np.arange(100.0), **moving})
    table.loc[: count - 1, "ft_fx"] = -40.0
    findings = check_force_sensor(table)
    assert [(one.code, one.count) for one in findings] == [("saturation", 10)] * reported
    table.loc[: count + 4, "ft_fz"] = 40.0
    assert [one.count for one in check_force_sensor(table)] == [count + 5]


def test_an_imu_at_its_full_scale_is_saturated() -> None:
    """Each sample once, whichever axis; the accelerometer's and the gyroscope's scales differ."""
    scale = FullScale(acceleration=50.0, angular_rate_deg=300.0)
    names = [f"imu_{quantity}{axis}" for quantity in "ag" for axis in "xyz"]
    table = pd.DataFrame(0.0, index=range(100), columns=["time", *names])
    table["imu_az"] = 9.81
    table.loc[3:4, "imu_ax"], table.loc[4:6, "imu_ay"] = 50.0, -50.3
    table.loc[10:16, "imu_gz"] = -np.deg2rad(300.0)
    below = table.clip(-49.9, 49.9).assign(imu_gz=table["imu_gz"].clip(-5.2, 5.2))
    assert check_imu(below, scale) == check_imu(table, None) == []
    (one,) = check_imu(table, scale)
    assert (one.device, one.code, one.count) == ("imu", "saturation", 11)
    assert one.severity == "warning"
    for name in ("imu_ax", "imu_ay", "imu_gz"):
        assert name in said(one)
    assert "imu_az" not in said(one)
    accelerometer = table.drop(columns=["imu_gx", "imu_gy", "imu_gz"])
    assert [one.count for one in check_imu(accelerometer, scale)] == [4]


@pytest.mark.parametrize(
    ("size", "reported"), [(7.9, True), (8.1, False), (11.9, False), (12.1, True)]
)
def test_an_accelerometer_feels_gravity(size: float, reported: bool) -> None:
    still = pd.DataFrame({"time": [0.0, 1.0], "imu_ax": 0.0, "imu_ay": 0.6 * size})
    still["imu_az"] = -0.8 * size
    assert [one.code for one in check_imu(still, None)] == [Found.NO_GRAVITY] * reported


def test_an_imu_in_the_place_of_a_force_sensor_is_reported() -> None:
    angle = np.linspace(0, 2 * np.pi, 400)
    turning = 9.81 * np.column_stack([np.cos(angle), np.sin(angle), 0.1 * np.sin(3 * angle)])
    names = ["ft_fx", "ft_fy", "ft_fz"]
    table = pd.DataFrame(turning, columns=names).assign(time=angle)
    assert found(check_force_sensor(table), Found.SIZE_OF_GRAVITY).severity == "warning"
    assert check_force_sensor(table.assign(ft_fx=table["ft_fx"] + 5)) == []
    assert check_force_sensor(table.iloc[:20]) == []  # a tool's weight on an arm at rest


def reported(table: pd.DataFrame, words: str) -> list[str]:
    return [one for one in contradictions(table) if words in one]


DERIVATIVE, TOGETHER = "actual_qd is not the derivative of actual_q ", "do not fit together"


@pytest.mark.parametrize(
    ("names", "factor", "words"),
    [
        ("actual_q_1", 0.92, ""),
        ("actual_q_1", 0.88, DERIVATIVE),
        ("actual_q_1", 1.08, ""),
        ("actual_q_1", 1.12, DERIVATIVE),
        ("actual_q_1", 57.3, "joint 2: 57.3,"),
        ("actual_qd_1", 1.2, "joint 2: 0.833,"),
        ("actual_current_", 0.04, TOGETHER),
        ("actual_current_", 0.06, ""),
        ("actual_current_", 19.0, ""),
        ("actual_current_", 21.0, TOGETHER),
        ("target_moment_", 0.45, "root mean square of target_moment"),
        ("target_moment_", 0.55, ""),
        ("target_moment_", 190.0, ""),
        ("target_moment_", 210.0, "root mean square of target_moment"),
    ],
)
def test_a_channel_of_another_size_is_reported(names: str, factor: float, words: str) -> None:
    """A ratio to the derivative is one within a tenth; those of currents and moments are wide."""
    table = moving_robot()
    table[[name for name in table if name.startswith(names)]] *= factor
    found = [one for one in contradictions(table) if DERIVATIVE in one or TOGETHER in one]
    assert len(found) == bool(words)
    assert all(words in one for one in found)


@pytest.mark.parametrize(("size", "judged"), [(0.065, False), (0.076, True)])
def test_a_joint_is_judged_that_moves_by_a_twentieth(size: float, judged: bool) -> None:
    """Of a radian per second, root mean square: a swing's peak is 1.41 times that."""
    table = moving_robot()
    time = table["time"].to_numpy()
    table["actual_qd_0"], table["actual_q_0"] = size * np.cos(time), 0.0
    table["target_q_0"] = 0.0
    assert bool(reported(table, "actual_qd is not the derivative of actual_q ")) == judged
    table["actual_qd_0"], table["actual_q_0"] = 0.0, size * np.sin(time)
    assert bool(reported(table, "actual_qd is not the derivative of actual_q ")) == judged


@pytest.mark.parametrize(("apart", "wrong"), [(2.4, False), (2.6, True)])
def test_currents_part_by_more_than_two_and_a_half_amperes(apart: float, wrong: bool) -> None:
    """In the median: half of the time they may be anywhere."""
    table = moving_robot()
    table["actual_current_2"] = table["target_current_2"] + apart
    assert bool(reported(table, "actual_current and target_current differ on joint 3;")) == wrong
    table.loc[: len(table) // 2 + 5, "actual_current_2"] = table["target_current_2"]
    assert not reported(table, "actual_current and target_current differ")


@pytest.mark.parametrize(("level", "wrong"), [(0.45, False), (0.55, True)])
def test_small_currents_are_not_compared(level: float, wrong: bool) -> None:
    """Below half an ampere there is only friction and noise."""
    table = moving_robot()
    size = np.sqrt(np.mean(table[CURRENTS].to_numpy() ** 2))
    for joint in range(6):
        table[f"actual_current_{joint}"] *= level / size
        table[f"target_current_{joint}"] = table[f"target_moment_{joint}"] = 0.0
    assert bool(reported(table, "root mean square of actual_current")) == wrong


@pytest.mark.parametrize(("share", "swapped"), [(0.32, False), (0.28, True)])
def test_a_swap_cuts_the_deviation_to_three_tenths(share: float, swapped: bool) -> None:
    """Each stands beside the other's target, by a part of what it is off its own."""
    table = moving_robot()
    for joint in range(6):
        for name in ("target_current", "actual_current", "target_moment"):
            table[f"{name}_{joint}"] = 10.0 * joint
    table["target_current_0"], table["target_current_1"] = 0.0, 1.0
    beyond = share / (1 - share)
    table["actual_current_0"], table["actual_current_1"] = 1.0 + beyond, -beyond
    assert bool(reported(table, "swapped")) == swapped


def test_what_is_missing_is_not_judged() -> None:
    """A recording of positions alone; rows that were filled in count for no derivative."""
    table = moving_robot()
    alone = table[["time", "segment", "interpolated", *(f"actual_q_{j}" for j in range(6))]]
    assert check_robot(alone, PERIOD, *LIMITS) == []
    filled = table.copy()
    filled.loc[100:2500, "interpolated"] = True
    filled.loc[101:2499, "actual_q_3"] *= 1.5
    assert not reported(filled, "not the derivative")


@pytest.mark.parametrize(("size", "reported"), [(2.9, False), (3.1, True)])
def test_gravity_turns_by_three_newtons_in_an_imu(size: float, reported: bool) -> None:
    """A tool's weight on an arm that hardly turns is no acceleration."""
    angle = np.linspace(0, 2 * np.arcsin(size / 2 / 9.81), 400) - np.arcsin(size / 2 / 9.81)
    force = 9.81 * np.column_stack([np.sin(angle), np.cos(angle), 0 * angle])
    table = pd.DataFrame(force, columns=["ft_fx", "ft_fy", "ft_fz"]).assign(time=angle)
    found = [one.code for one in check_force_sensor(table)]
    assert (Found.SIZE_OF_GRAVITY in found) == reported


@pytest.mark.parametrize(
    ("newton", "seconds", "mass", "found"),
    [
        *((29.0, 1.0, 0.0, 1), (14.0, 1.0, 0.0, 0), (29.0, 0.4, 0.0, 0)),
        *((34.0, 1.0, 1.0, 0), (35.0, 1.0, 1.0, 1)),
    ],
)
def test_a_contact_in_a_free_recording_is_found(
    newton: float, seconds: float, mass: float, found: int
) -> None:
    """29 N for a second; less, shorter, or twice the weight of a tool, which turns, is none."""
    time = np.arange(0, 10, 0.01)
    force = np.where(time < seconds, newton, 0.0) + 3.0  # and a bias
    table = pd.DataFrame({"time": time, "ft_fx": force, "ft_fy": 0.0, "ft_fz": -4.0})
    assert len(sensed_contacts(table, mass)) == found


def told_at_10_hz(hertz: float, period: float = 0.1, leap: float = 0.0) -> list[str]:
    """What is said of joint 2, which swings beside a slow joint, by samples of a period [s].

    leap: in the middle of the log [rad], as where two logs were joined.
    """
    time = 0.1 * np.arange(100)
    q = np.stack([0.5 * np.sin(2 * np.pi * f * time + 1) for f in (0.1, hertz)], axis=1)
    q[50:] += leap
    moved = q, np.zeros(len(q), int), period, [15.0, 15.0]
    return [*map(said, [*untold_motion(*moved), *fast_between_samples(*moved)])]


@pytest.mark.parametrize(
    ("hertz", "sentences"),
    [
        (0.2, []),
        (1.0, []),
        (1.5, ["motion of joint 2 is faster"]),
        (4.0, ["do not tell the motion of joint 2"]),
    ],
)
def test_a_slow_log_says_where_motion_is_faster_than_it_tells(
    hertz: float, sentences: list[str]
) -> None:
    """A log at 33 Hz and more is fast enough for any arm."""
    said_of_it = told_at_10_hz(hertz)
    assert len(said_of_it) == len(sentences)
    assert all(part in own for part, own in zip(sentences, said_of_it, strict=True))
    assert told_at_10_hz(hertz, 0.004) == []
    assert told_at_10_hz(hertz, leap=2.0) == said_of_it


def missed_share(hertz: float) -> float:
    """What a spline of degree 5 through every second sample misses, over what a line does.

    Of a wave at 10 Hz, by B-splines at whole places and halves.
    """
    turn = 2 * np.pi * hertz * 0.1  # of one sample
    whole = (66 + 52 * np.cos(2 * turn) + 2 * np.cos(4 * turn)) / 120
    half = (3364 * np.cos(turn) + 474 * np.cos(3 * turn) + 2 * np.cos(5 * turn)) / 3840
    return abs(half / whole - 1) / (1 - np.cos(turn))


@pytest.mark.parametrize(
    ("share", "word"), [(0.1, "is faster than samples"), (0.5, "do not tell the motion")]
)
def test_a_spline_may_miss_a_tenth_of_the_curvature_and_misses_all_from_a_half_on(
    share: float, word: str
) -> None:
    for side, beyond in ((0.94, False), (1.06, True)):
        hertz = brentq(lambda one, limit: missed_share(one) - limit, 0.5, 3.5, share * side)
        wave = np.hanning(2000) * np.sin(2 * np.pi * hertz * 0.1 * np.arange(2000))
        q = 5.0 * wave[:, None]
        log = q, np.zeros(len(q), int), 0.1, [100.0]
        told = [*map(said, [*untold_motion(*log), *fast_between_samples(*log)])]
        assert any(word in one for one in told) == beyond


@pytest.mark.parametrize(
    ("count", "period", "told"),
    [(12, 0.1, 1), (11, 0.1, 0), (12, 0.031, 1), (12, 0.029, 0), (12, 0.04, 1)],
)
def test_twelve_samples_of_a_slow_log_tell_how_it_moves(
    count: int, period: float, told: int
) -> None:
    q = 0.1 * (-1.0) ** (np.arange(count) // 2)[:, None]
    assert len([*untold_motion(q, np.zeros(count, int), period, [100.0])]) == told
    still, later = np.zeros((40, 1)), np.repeat([0, 1], [40, count])
    assert len([*untold_motion(np.vstack([still, q]), later, period, [100.0])]) == told


@pytest.mark.parametrize(
    ("period", "of_fit", "told"),
    [
        (0.03, None, []),
        (0.033, None, [Found.SLOW_SAMPLES]),  # eight of 31 ms average into one at 2 Hz
        (0.033, 0.0225, []),
        (0.033, 0.0215, [Found.SLOWER_THAN_FIT]),  # by more than half
    ],
)
def test_a_slow_recording_leaves_noise_where_a_faster_one_was_fitted(
    period: float, of_fit: float | None, told: list[Found]
) -> None:
    q, whole = np.arange(50.0)[:, None] * 0.1, np.zeros(50, int)
    assert [one.code for one in slow_samples(q, whole, period, 2.0, of_fit)] == told
    assert slow_samples(0 * q, whole, period, 2.0, of_fit) == []


def test_a_part_is_long_enough_with_one_sample_between_its_ends() -> None:
    """A low-pass at 2 Hz extrapolates a quarter of a second at each end: 25 samples of 51."""
    whole = np.repeat([0, 1, 2], [51, 30, 40])
    assert too_short(whole, 0.01, 2.0) == []
    (warning,) = too_short(whole[1:], 0.01, 2.0)
    assert "no more than 50 samples, 0.5 s, without a gap" in warning.detail
    assert "needs 0.51 s" in warning.detail


def test_motion_that_samples_do_not_tell_is_a_stop_sign() -> None:
    log = poor_log(load_robot(robot_path("ur5")), 40, seed=1, speed=1.5)
    for every, stops in ((1, False), (12, False), (125, True)):  # at 125, 10 and 1 Hz
        table = log[::every].reset_index(drop=True).assign(segment=0, interpolated=False)
        checked = Checked(table, load_robot(robot_path("ur5")), None, None, True, cutoff=2.0)
        causes = [sign.cause for sign in stop_signs(checked)]
        assert (CauseCode.UNTOLD_MOTION in causes) == stops


def test_few_other_arms_are_named_that_fit_as_well_and_never_its_own() -> None:
    """Before, thirteen, and the described arm beside its individual of another name."""
    described = load_robot(robot_path("ur5"))
    own = described.model_copy(update={"name": "mine"})
    log = poor_log(described, 10.0, seed=1).drop(columns=CURRENTS)
    checked = Checked(log.assign(segment=0, interpolated=False), own, None, None, False, cutoff=2.0)
    told = said(found(unchecked(checked), Found.ARM_NOT_CHECKED)).partition("told from ")[2]
    *named, more = told.partition(":")[0].split(" or ")
    assert len(named) == MAX_NAMED
    assert more == f"{len(checked.others) - 1 - MAX_NAMED} more"
    assert not {"ur5", "mine"} & {*named}
