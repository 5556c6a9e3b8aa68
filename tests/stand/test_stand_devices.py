"""What the virtual test stand writes is what real devices write, faults and noise included."""

import re
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError

from tests.entries import read_and_check
from tests.real_arms import RealStudy
from ur5lib.force.estimators import Run, controller
from ur5lib.force.sensor import fit_offset, move_to_frame_6, wrench_of_environment
from ur5lib.recordings.entries import ThesisFiles
from ur5lib.recordings.intake import Intake
from ur5lib.recordings.realtime_stream import read_stream
from ur5lib.recordings.thesis_csv import read_thesis_csv
from ur5lib.records.carried import configured_payload
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import flange_kinematics
from ur5lib.signals.own_clocks import own_clocks
from ur5lib.stand.faults import (
    FIRST_PART_BYTES,
    LATE_PACKET_INTERVAL,
    draw_faulty_frames,
    receipts_with_late_packets,
)
from ur5lib.stand.plan import Faults, SimulatedRecording
from ur5lib.stand.simulate import Format, simulate
from ur5lib.study.reading import parse_study
from ur5lib.tables import channel, read_json, read_table
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.sampling import interpolated

FOURIER: dict[str, Any] = {"kind": "fourier"}
HOME = (2.181661, -2.135061, -1.745329, 0.275936, -6.021385, 0.0)
AWAY = tuple(np.deg2rad([45.7, -175, -20, -88, -240, 150]).tolist())
SINGULARITY_FREE = {
    "kind": "movej",
    "way_points": [HOME, AWAY],
    "speed_rad_s": np.deg2rad(60),
    "acceleration_rad_s2": np.deg2rad(80),
}
WALL = {"kind": "wall", "through": [0, 0, 0], "normal": [0, 0, 1]}
PUSH = {"kind": "push", "start_s": 3, "force": [30, 0, -20]}
SHORT_PUSH = PUSH | {"start_s": 0.5, "seconds": 1}
FORMATS: list[Format] = ["thesis-csv", "realtime-stream", "rtde-csv"]

Recorder = Callable[..., "Recorded"]


class Recorded:
    """One simulated recording, its truth, and how a study names it."""

    def __init__(self, robot: str, format: Format, folder: Path, plan: dict[str, Any]) -> None:
        self.arm = load_robot(robot_path(robot))
        self.folder, self.truth = folder / "raw", folder / "truth"
        plan = {"trajectory": FOURIER, "seconds": 5} | plan
        self.plan = SimulatedRecording.model_validate(plan)
        entry = {"name": "made", "robot": robot, "format": format, "role": "fit"}
        raw = {"study": "made", "title": "Made", "recordings": [entry | {"simulate": plan}]}
        recording = parse_study(raw, "made.yaml").recordings[0]
        self.entry = recording.model_dump() | {"folder": str(self.folder)}
        self.files = recording.file_names()
        simulate(self.arm, self.plan, format, self.folder, self.truth)

    def written(self) -> set[str]:
        files = (path for path in self.folder.rglob("*") if path.is_file())
        return {str(path.relative_to(self.folder)) for path in files}

    @cached_property
    def repaired(self) -> Intake:
        return read_and_check(self.entry, self.arm, 0.1)

    def true(self) -> pd.DataFrame:
        return read_table(f"{self.truth}.parquet")

    def summary(self) -> Any:
        return read_json(f"{self.truth}.json")


@pytest.fixture(scope="module")
def record(tmp_path_factory: pytest.TempPathFactory) -> Recorder:
    def record(format: Format = "thesis-csv", robot: str = "ur5", **plan: Any) -> Recorded:
        return Recorded(robot, format, tmp_path_factory.mktemp("stand"), plan)

    return record


@pytest.fixture(scope="module")
def like_no8(record: Recorder) -> Recorded:
    """The motion of Movement_No8_Singularity_Free_1, as long."""
    return record(
        trajectory=SINGULARITY_FREE, seconds=16, imu={}, force_sensor={}, contacts=[PUSH], seed=3
    )


def findings(intake: Intake) -> dict[tuple[str, str], Finding]:
    return {(f.device, f.code): f for f in intake.quality.findings}


# Files


@pytest.mark.parametrize("format", FORMATS)
def test_the_same_plan_gives_the_same_bytes(record: Recorder, format: Format) -> None:
    faults = {"lost_frames": 0.02, "stale_frames": 0.01, "torn_files": True, "late_packets": True}
    plan = {"imu": {}, "force_sensor": {}, "contacts": [SHORT_PUSH], "faults": faults, "seconds": 2}
    one, other = (record(format, **plan, seed=seed) for seed in (5, 5))
    for file in one.written():
        assert (one.folder / file).read_bytes() == (other.folder / file).read_bytes()
    for suffix in (".json", ".parquet"):
        truths = [Path(f"{recorded.truth}{suffix}").read_bytes() for recorded in (one, other)]
        assert truths[0] == truths[1]
    another = record(format, **plan, seed=6)
    robot = one.files[0]
    assert (one.folder / robot).read_bytes() != (another.folder / robot).read_bytes()


@pytest.mark.parametrize("robot", ["ur5", "ur10e"])
@pytest.mark.parametrize("format", FORMATS)
def test_readers_find_nothing_amiss(record: Recorder, format: Format, robot: str) -> None:
    recorded = record(format, robot, imu={}, force_sensor={}, contacts=[SHORT_PUSH], seconds=3)
    assert recorded.written() == {*recorded.files}
    intake = recorded.repaired
    assert not intake.quality.findings
    assert intake.quality.devices == ["robot", "force", "imu"]
    assert intake.quality.period_s == (0.002 if format == "rtde-csv" else 0.008)
    assert len(intake.robot) == len(recorded.true())
    np.testing.assert_allclose(intake.robot["time"], recorded.true()["time"], atol=1e-9)


@pytest.mark.parametrize("format", FORMATS)
def test_a_controller_knows_the_payload_that_its_files_name(
    record: Recorder, format: Format
) -> None:
    """RTDE's channels name it and `target_moment` has it; other files have neither."""
    payload = {"mass": 2.0, "center_of_mass": [0.01, -0.02, 0.06], "inertia": [0.01] * 3 + [0] * 3}
    loaded, bare = (
        record(format, seconds=1.5, trajectory={"kind": "standstill"}, friction=False, **carried)
        for carried in ({"payload": payload}, {})
    )
    robot = loaded.repaired.robot
    more = channel(robot, "target_moment") - channel(bare.repaired.robot, "target_moment")
    found = configured_payload(Signals.from_table(robot))
    if format == "rtde-csv":
        assert found == loaded.plan.payload
        assert np.abs(more).max() > 10
    else:
        assert found is None
        assert np.abs(more).max() == 0
    shift = channel(loaded.true(), "tau_motor")[-1] - channel(bare.true(), "tau_motor")[-1]
    assert np.abs(shift).max() > 10


def test_truth_lies_apart(like_no8: Recorded) -> None:
    """Nothing that a reader is shown holds it, and it holds all that was drawn or chosen."""
    assert not [name for name in like_no8.written() if "truth" in name]
    summary = like_no8.summary()
    assert summary["model"] == "C+rotors"
    assert summary["clocks"]["imu"] == {"offset_s": 0.02, "drift_ppm": -3000}
    assert summary["plan"]["imu"]["gyroscope_bias"] == [-0.031, 0.024, 0.027]
    assert len(summary["friction"]["coulomb"]) == len(summary["drive"]["torque_constant"]) == 6
    [[start, end]] = summary["contacts"]
    assert (start, end) == pytest.approx((3, 5), abs=0.002)


def test_what_is_told_of_friction_explains_it(like_no8: Recorded) -> None:
    """Coulomb, load, viscous and periodic parts, where a joint slides: within 2 %."""
    true, robot = like_no8.true(), like_no8.repaired.robot
    q, qd = channel(true, "q"), channel(true, "qd")
    load = channel(robot, "target_moment") - channel(true, "tau_contact")  # what the gears transmit
    part = {name: np.array(value) for name, value in like_no8.summary()["friction"].items()}
    dry = part["coulomb"] + part["load"] * np.abs(load)
    periodic = part["periodic"] * np.cos(q + part["phase"])
    told = np.sign(qd) * dry + part["viscous"] * qd + periodic
    off = np.abs(told - channel(true, "tau_friction"))
    sliding = np.abs(qd) > 0.1
    assert sliding.sum(axis=0).min() > 500
    for joint in range(6):
        assert np.quantile(off[sliding[:, joint], joint], 0.95) < 0.02 * part["coulomb"][joint]


def test_a_sensor_that_is_not_there(record: Recorder) -> None:
    recorded = record("thesis-csv")
    assert recorded.written() == {*recorded.files}
    intake = recorded.repaired
    assert intake.quality.devices == ["robot"]
    assert {f.code for f in intake.quality.findings} == {Found.NO_SENSOR}
    assert record("realtime-stream").repaired.quality.devices == ["robot"]


# Channels


def test_without_noise_channels_are_the_truth(record: Recorder) -> None:
    recorded = record(noise=False, friction=False, force_sensor={}, contacts=[PUSH])
    robot, true = recorded.repaired.robot, recorded.true()
    constant = recorded.summary()["drive"]["torque_constant"]
    for name, values in (
        ("actual_q", channel(true, "q")),
        ("actual_qd", channel(true, "qd")),
        ("actual_current", channel(true, "tau_motor") / constant),
    ):
        np.testing.assert_allclose(channel(robot, name), values, atol=6e-7)
    np.testing.assert_allclose(
        channel(robot, "target_moment"), constant * channel(robot, "target_current"), atol=2e-5
    )
    _, origin, J = flange_kinematics(recorded.arm, channel(true, "q"))
    np.testing.assert_allclose(channel(robot, "actual_TCP_pose")[:, :3], origin, atol=1e-6)
    speed = np.einsum("nij,nj->ni", J, channel(true, "qd"))
    np.testing.assert_allclose(channel(robot, "actual_TCP_speed"), speed, atol=1e-6)


@pytest.mark.parametrize(("format", "robot"), [("thesis-csv", "ur5"), ("rtde-csv", "ur5e")])
def test_the_controller_s_force_is_that_of_the_arm(
    record: Recorder, format: Format, robot: str
) -> None:
    """At frame 6, axes of the base: a steady pull at rest, no friction to hide it.

    An e-Series controller states that of the environment on the arm, whatever its wrist sensor
    reads; others state that of the arm on its environment.
    """
    spring = {"kind": "spring", "start_s": 1, "seconds": 4, "displacement": [0.06, -0.04, 0.02]}
    still = {"trajectory": {"kind": "standstill"}, "friction": False, "contacts": [spring]}
    recorded = record(format, robot, **still)
    signals, time = Signals.from_table(recorded.repaired.robot), recorded.true()["time"]
    force = channel(recorded.repaired.robot, "actual_TCP_force")
    stated = controller(Run(None, None, None, controller=signals.wrench_calc_from_currents))
    told = -force if stated is None else stated.wrench
    true = channel(recorded.true(), "wrench")[(time > 2.96) & (time < 3.04)].mean(axis=0)
    assert np.abs(true[:3]).min() > 5
    assert np.abs(true[3:]).max() > 0.5
    assert (stated is None) == (robot == "ur5")
    told = told[(signals.time > 2.96) & (signals.time < 3.04)].mean(axis=0)
    np.testing.assert_allclose(told, true, atol=1.5)


# Clocks and sensors


@pytest.mark.parametrize("format", FORMATS[::2])
def test_the_imu_s_clock_comes_back(record: Recorder, format: Format) -> None:
    clock = {"offset_s": 0.05, "drift_ppm": -2500, "jitter_s": 1e-4, "stamp_error_s": -0.06}
    recorded = record(format, imu={"clock": clock}, seconds=12)
    intake = recorded.repaired
    robot = Signals.from_table(intake.robot)
    rotation, _, jacobian = flange_kinematics(recorded.arm, robot.actual_q)
    found = own_clocks(intake.quality.starts, intake.sensors, robot, rotation, jacobian)["imu"]
    assert found.warning is None
    assert found.offset == pytest.approx(0.05, abs=0.005)
    assert found.drift == pytest.approx(-2500e-6, abs=5e-4)


def off_the_true_wrench(recorded: Recorded) -> tuple[float, Array]:
    """The tool's mass [kg] and the wrench's errors (N, 6), by the steps of real recordings."""
    sensor, true = recorded.repaired.sensors["force"], recorded.true()
    time = sensor["time"].to_numpy() + recorded.summary()["clocks"]["force"]["offset_s"]

    def at_samples(name: str, count: int) -> Array:
        return interpolated(time, true["time"].to_numpy(), channel(true, name, count))

    rotation = at_samples("R6", 9).reshape(-1, 3, 3)
    reading = sensor.drop(columns="time").to_numpy(copy=True)
    gravity = np.array(recorded.arm.gravity)
    offset = fit_offset(reading, gravity @ rotation, 1 / 207)
    there = wrench_of_environment(reading - offset.reading(gravity @ rotation), rotation)
    wrench = move_to_frame_6(there, rotation, np.array(recorded.arm.mounting.force_sensor))
    return offset.mass, wrench - at_samples("wrench", 6)


@pytest.mark.parametrize("format", FORMATS[::2])
def test_the_force_sensor_tells_the_true_wrench(record: Recorder, format: Format) -> None:
    recorded = record(format, force_sensor={}, contacts=[PUSH], seconds=12)
    _, off = off_the_true_wrench(recorded)
    assert np.abs(off[:, :3]).max() < 0.1
    assert np.abs(off[:, 3:]).max() < 0.02
    assert np.abs(channel(recorded.true(), "wrench")[:, :3]).max() > 25


def test_the_force_sensor_tells_its_tool(record: Recorder) -> None:
    """In a slow motion: the inertia of a tool is no part of its weight."""
    tool = {"mass": 1.5, "center_of_mass": [0.01, -0.02, 0.06]}
    slow = FOURIER | {"period_s": 40, "amplitude_rad": 1.2}
    recorded = record(force_sensor={}, contacts=[PUSH], payload=tool, trajectory=slow, seconds=20)
    mass, off = off_the_true_wrench(recorded)
    assert mass == pytest.approx(1.5, abs=0.01)
    assert np.abs(off[:, :3]).max() < 1.0
    assert np.abs(off[:, 3:]).max() < 0.1


def test_saturation_is_seen(record: Recorder) -> None:
    plan = {"bias": [0, 0, 0, 0, 0, 0], "saturation_n": 12}
    recorded = record(force_sensor=plan, contacts=[PUSH])
    intake = recorded.repaired
    assert ("force", "saturation") in findings(intake)
    assert intake.sensors["force"][["ft_fx", "ft_fy", "ft_fz"]].abs().max(axis=None) == 12


# Faults


@pytest.mark.parametrize("fault", ["lost_frames", "cut_frames", "stale_stamps", "stale_frames"])
def test_the_first_two_frames_and_the_last_have_no_fault(fault: str) -> None:
    """However many have: a reader accepts the first only if the second is complete."""
    random, faults = np.random.default_rng(0), Faults.model_validate({fault: 0.5})
    frames = (vars(draw_faulty_frames(faults, 100, random)) for _ in range(20))
    drawn = np.array([[*faulty.values()] for faulty in frames])
    assert not drawn[:, :, [0, 1, -1]].any()
    assert drawn.any(axis=(0, 1))[2:-1].all()


def unequal(own: pd.DataFrame, other: pd.DataFrame) -> Array:
    """Which rows (N,) of two tables are not the same to the bit, in the channels of the other."""
    columns = [name for name in other.columns if re.fullmatch(r"time|.*_\d", name)]
    bits = [table[columns].to_numpy().view(np.int64) for table in (own, other)]
    return (bits[0] != bits[1]).any(axis=1)


@pytest.mark.parametrize("lost", [0.0, 0.04])
def test_a_faulty_stream_is_repaired_to_the_clean_log_to_the_bit(
    record: Recorder, lost: float
) -> None:
    """Every frame that was sent whole, beside the decoded log of the same run."""
    plan = {"contacts": [PUSH], "imu": {}, "force_sensor": {}, "seconds": 6, "seed": 8}
    clean = record("thesis-csv", **plan).repaired.robot
    faulty = record("realtime-stream", **plan, faults={"late_packets": True, "lost_frames": lost})
    robot, missing = faulty.repaired.robot, faulty.summary()["frames"]["lost"]
    assert len(missing) == pytest.approx(lost * len(clean), abs=20)
    assert len(robot) == len(clean)
    np.testing.assert_array_equal(np.flatnonzero(robot["interpolated"]), missing)
    assert set(np.flatnonzero(unequal(robot, clean))) <= set(missing)


def test_cut_messages_cost_themselves_and_at_most_a_neighbour(record: Recorder) -> None:
    """What is left is right to the bit, damage on top of late packets and all."""
    plan = {"seconds": 6, "seed": 1}
    clean = record("thesis-csv", **plan).repaired.robot
    faulty = record("realtime-stream", **plan, faults={"late_packets": True, "cut_frames": 0.03})
    robot, cut = faulty.repaired.robot, np.array(faulty.summary()["frames"]["cut"])
    frame = np.rint((robot["time"].to_numpy()) / 0.008).astype(int)
    doubtful = robot["interpolated"].to_numpy()
    assert not unequal(robot, clean.iloc[frame])[~doubtful].any()
    lost = np.setdiff1d(np.arange(len(clean)), frame[~doubtful])
    assert set(cut) <= set(lost)
    assert len(lost) <= 1.2 * len(cut)
    assert all(np.abs(cut - frame).min() <= 1 for frame in lost)


def test_late_packets_come_as_figure_4_4_shows() -> None:
    sent = [bytes([k]) * 756 for k in range(8)]
    time = np.arange(8) * 0.008
    received = receipts_with_late_packets(sent, time, np.array([False, *[True] * 7]))
    assert b"".join(data for _, data in received) == b"".join(sent)
    assert [(round(1000 * at), len(data)) for at, data in received] == [
        (0, 756), (8, 756), (16, 756), (32, 756 + FIRST_PART_BYTES), (33, 62),
        (40, 756), (56, 756 + FIRST_PART_BYTES), (57, 62),
    ]  # fmt: skip
    assert LATE_PACKET_INTERVAL == 3
    last = receipts_with_late_packets(sent[:4], time[:4], np.ones(4, bool))
    assert b"".join(data for _, data in last) == b"".join(sent[:4])


def test_a_capture_has_the_real_layout(record: Recorder) -> None:
    recorded = record("realtime-stream", faults={"late_packets": True})
    frame, found = read_stream(recorded.folder / "capture.csv")
    assert not found
    assert frame.attrs["message_bytes"] == 756
    steps = np.rint(1000 * np.diff(frame["received"])).astype(int)
    assert set(steps) <= {1, 7, 8, 9, 15, 16}
    assert np.count_nonzero(steps == 1) > 100
    assert (frame["joint_temperatures_0"] == 30).all()


@pytest.mark.parametrize(
    ("format", "fault", "found"),
    [
        ("thesis-csv", {"lost_frames": 0.05}, ("robot", Found.LOST_FRAMES)),
        ("realtime-stream", {"lost_frames": 0.05}, ("robot", Found.LOST_FRAMES)),
        ("realtime-stream", {"cut_frames": 0.05}, ("robot", Found.BYTES_SKIPPED)),
        ("rtde-csv", {"lost_frames": 0.05}, ("robot", Found.LOST_FRAMES)),
        ("thesis-csv", {"stale_stamps": 0.02}, ("robot", Found.REPEATED_STAMPS)),
        ("realtime-stream", {"stale_stamps": 0.02}, ("robot", Found.STALE_STAMPS)),
        ("rtde-csv", {"stale_stamps": 0.02}, ("robot", Found.STALE_STAMPS)),
        ("thesis-csv", {"stale_frames": 0.02}, ("robot", Found.STALE_DATA)),
        ("realtime-stream", {"stale_frames": 0.02}, ("robot", Found.STALE_DATA)),
        ("rtde-csv", {"stale_frames": 0.02}, ("robot", Found.STALE_DATA)),
        ("thesis-csv", {"torn_files": True}, ("robot", Found.CHANNELS_OF_UNEQUAL_LENGTH)),
        ("realtime-stream", {"torn_files": True}, ("robot", Found.DAMAGED_LINES)),
        ("rtde-csv", {"torn_files": True}, ("robot", Found.TORN_LAST_LINE)),
        ("thesis-csv", {"stale_imu": True}, ("imu", Found.STALE_COPY)),
        ("realtime-stream", {"stale_imu": True}, ("imu", Found.STALE_COPY)),
        ("rtde-csv", {"stale_imu": True}, ("imu", Found.STALE_COPY)),
    ],
)
def test_each_fault_is_found_and_survived(
    record: Recorder, format: Format, fault: dict[str, Any], found: tuple[str, str]
) -> None:
    recorded = record(format, faults=fault, imu={}, seconds=3)
    intake = recorded.repaired
    assert found in findings(intake)
    true = recorded.true().set_index("time")
    near = true.index.get_indexer(intake.robot["time"], method="nearest")
    off = channel(intake.robot, "actual_q") - channel(true.iloc[near], "q")
    assert np.abs(off).max() < 0.03  # a cycle at full speed, where a stamp was stale


# Beside the real devices


def residual(robot: pd.DataFrame) -> Array:
    """RMS of the current above 2 Hz that the controller did not foresee, while the arm moves."""
    off = channel(robot, "actual_current") - channel(robot, "target_current")
    moving = np.abs(channel(robot, "target_qd")).max(axis=1) > 1e-3
    return np.std((off - zero_phase_lowpass(off, 125, 4, 2.0))[moving], axis=0)


@pytest.fixture(scope="module")
def real_no8(real_ur5: RealStudy) -> Intake:
    return real_ur5.recording("Movement_No8_Singularity_Free_1").intake


def off_target(taken: Intake, name: str) -> Array:
    robot = taken.robot
    return channel(robot, f"actual_{name}") - channel(robot, f"target_{name}")


def stillest(quantity: str) -> Callable[[Intake], Array]:
    """Least standard deviation over a second of samples of an IMU, axis by axis."""
    columns = [f"imu_{quantity}{axis}" for axis in "xyz"]
    return lambda taken: taken.sensors["imu"][columns].rolling(266).std().min().to_numpy()


NOISE: dict[str, tuple[Callable[[Intake], Array], float]] = {  # and the factor that it may be off
    "currents": (lambda taken: residual(taken.robot), 1.25),
    "positions": (lambda taken: np.diff(off_target(taken, "q"), 3, axis=0).std(axis=0), 1.35),
    "velocities": (lambda taken: off_target(taken, "qd").std(axis=0), 1.35),
    "drives": (lambda taken: off_target(taken, "q").std(axis=0), 2.0),
    "gyroscope": (stillest("g"), 1.3),
    "magnetometer": (stillest("m"), 1.3),
    "accelerometer": (stillest("a"), 2.5),  # the real one also feels the arm tremble
}


@pytest.mark.parametrize(("measure", "factor"), NOISE.values(), ids=NOISE)
def test_devices_are_as_noisy_as_real_ones(
    like_no8: Recorded, real_no8: Intake, measure: Callable[[Intake], Array], factor: float
) -> None:
    """Channel by channel, on the same motion; the IMU at rest (Table 4.5)."""
    ratio = measure(like_no8.repaired) / measure(real_no8)
    assert (np.abs(np.log(ratio)) < np.log(factor)).all(), ratio


def test_sensors_keep_time_and_are_noisy_as_real_ones(
    like_no8: Recorded, real_no8: Intake, thesis_data: Path
) -> None:
    """Mean step within 0.5 %, its standard deviation within a quarter; of a force sensor at rest,
    the first second's noise from sample to sample within a third.
    """
    folder = thesis_data / "Movement_No10_Standstill_ForceSensor_All"
    entry = ThesisFiles(format="thesis-csv", folder=str(folder))
    force = read_thesis_csv(entry).sensors["force"].table
    made = like_no8.repaired.sensors
    for device, table in {"imu": real_no8.sensors["imu"], "force": force}.items():
        steps, own = (np.diff(t["time"]) for t in (table, made[device]))
        assert own.mean() == pytest.approx(steps.mean(), rel=0.005)
        assert own.std() == pytest.approx(steps.std(), rel=0.25)
    noise = [
        t.drop(columns="time").iloc[:190].diff().std().to_numpy() for t in (made["force"], force)
    ]
    np.testing.assert_allclose(noise[0], noise[1], rtol=0.35)


# Plans


@pytest.mark.parametrize(
    "wrong",
    [
        {"trajectory": {"kind": "fourier", "amplitude": 1}},
        {"trajectory": {"kind": "circle"}},
        {"trajectory": FOURIER, "seconds": 0},
        {"trajectory": FOURIER, "faults": {"lost_frames": 0.9}},
        {"trajectory": FOURIER, "contacts": [{"kind": "push", "force": [1, 2, 3]}]},
        {
            "trajectory": FOURIER,
            "contacts": [{"kind": "push", "start_s": 1, "force": [1, 2, np.nan]}],
        },
        {"trajectory": FOURIER, "contacts": [WALL | {"link": 0}]},
        {"trajectory": FOURIER, "contacts": [WALL | {"normal": [0, 0, 0]}]},
    ],
)
def test_a_wrong_plan_is_refused(wrong: dict[str, Any]) -> None:
    SimulatedRecording.model_validate({"trajectory": FOURIER, "contacts": [WALL, PUSH]})
    with pytest.raises(ValidationError):
        SimulatedRecording.model_validate(wrong)


def test_every_choice_of_a_plan_is_described() -> None:
    schema = SimulatedRecording.model_json_schema()
    for name, part in {"SimulatedRecording": schema, **schema["$defs"]}.items():
        for key, value in part["properties"].items():
            told = "description" in value or "const" in value or "$ref" in str(value)
            assert told or key.endswith(("_s", "_n_m", "_ns_m", "seconds")) or name == "Payload", (
                key
            )
