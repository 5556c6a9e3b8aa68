"""On floor, ceiling and slope alike, the steps find tool, biases, tilt and forces."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.steps.made_recording import known_of
from ur5lib.identification.current_samples import current_record
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.judgement import Judgement
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import ForceSensor, Imu
from ur5lib.stand.truth import TrueParameters, Truth
from ur5lib.steps.align_recording import align_recording
from ur5lib.steps.calibrate_imu import calibrate_imu
from ur5lib.steps.compare_accelerations import compare_accelerations
from ur5lib.steps.compute_torques import compute_torques
from ur5lib.steps.judge_recording import judge_recording
from ur5lib.steps.judge_sensor import judge_sensor
from ur5lib.steps.make_tables import OF_RECORDINGS, rows_of_recordings
from ur5lib.steps.read_recording import read_recording
from ur5lib.steps.simulate_recording import simulate_recording
from ur5lib.study.reading import parse_study
from ur5lib.tables import read_record, write_table
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth

MOUNTINGS = {  # gravity in the base frame [m/s²]
    "floor": None,
    "ceiling": [0.0, 0.0, 9.81],
    "slope": [9.81 * np.sin(np.pi / 6), 0.0, -9.81 * np.cos(np.pi / 6)],
}
TOOL = {"mass": 1.0, "center_of_mass": [0.01, -0.02, 0.06]}
LEVER = np.array([0.01, -0.02, 0.06 - 0.0286])  # from the sensor to the tool's centre [m]
PUSHES = {4.0: [40, 0, 0], 7.0: [0, -40, 0], 10.0: [0, 0, 40]}  # N, by when they peak [s]
PLAN: dict[str, Any] = {
    # slow, as the inertia of a tool is no part of its weight
    "trajectory": {"kind": "fourier", "period_s": 40, "amplitude_rad": 1.2},
    "seconds": 12,
    "contacts": [
        {"kind": "push", "start_s": peak - 1, "seconds": 2, "force": force}
        for peak, force in PUSHES.items()
    ],
    "friction": False,  # so that currents tell torques
    "payload": TOOL,
    "force_sensor": {},
    "imu": {},
}
LOWPASS, CUTOFF, MAX_GAP = Butterworth(4, 2.0), 2.0, 0.1  # Hz, s


class Mounted:
    """A recording of an arm that hangs somewhere, and what the steps make of it.

    The IMU is calibrated on the motion itself, as if that were another recording.
    """

    def __init__(self, arm: Robot, gravity: list[float] | None, folder: Path) -> None:
        made: dict[str, Any] = {"name": "made", "robot": "ur5", "format": "thesis-csv"}
        made |= {"role": "fit", "gravity": gravity, "simulate": PLAN}
        study = parse_study({"study": "made", "title": "Made", "recordings": [made]}, "made.yaml")
        entry: Any = study.recordings[0]
        entry, file = entry.model_copy(update={"folder": f"{folder}/raw"}), folder / "s.parquet"
        truth = folder / "truth"
        simulate_recording(arm, entry.simulate, entry.format, entry.folder, str(truth), gravity)
        self.truth = Truth.read(f"{truth}.parquet")
        self.parameters = read_record(TrueParameters, f"{truth}.json")
        raw = [Path(entry.folder, name) for name in entry.file_names()]
        read = read_recording(entry, raw, arm, MAX_GAP)
        aligned = align_recording(read.robot, read.force, read.imu, read.clocks)
        write_table(aligned.signals, file)
        signals = Signals.read(file)
        others = {"other": signals}, {"other": read.kinematics}, {"other": aligned.alignment}
        self.calibration = calibrate_imu(arm, *others, {"other": gravity}, LOWPASS)
        known = {"signals": signals, "motion": aligned.motion, "gravity": gravity}
        own = AlignedRecording(role="fit", untouched=None, **known)
        torques, premises = compute_torques(own, arm, {"currents": CUTOFF}, entry.known_payload())
        self.known = known_of(
            arm,
            signals,
            aligned.motion,
            read.kinematics,
            quality=read.quality,
            force=read.force,
            alignment=aligned.alignment,
            torques=torques,
            premises=premises,
            gravity=gravity,
        )
        known = {"imu": read.imu, "calibration": self.calibration, "lowpass": LOWPASS}
        known |= {"calibration_without_each": self.calibration}
        self.beside = self.known.but(**known).run(compare_accelerations)
        self.fused, self.beside_imu = self.beside.fused, self.beside.comparison
        self.sensor, self.beside_sensor = self.known.run(judge_sensor)

    def by_sensor(self) -> Array:
        """Contact force (N, 3) [N], less bias and the tool's weight."""
        return self.sensor.wrench["compensated"][:, :3]

    def by_currents(self) -> Array:
        """Contact force (N, 3) [N] by what currents, link model and known payload leave."""
        own = self.known
        record = current_record(AlignedRecording(**vars(own)), own.arm)
        assert record is not None
        external = record.torque - self.parameters.drive.torque_constant * record.current
        wrench = np.linalg.solve(own.kinematics.jacobian.mT, external[..., None])
        return wrench[:, :3, 0]


@pytest.fixture(scope="module")
def arm(ur5: Robot, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Mounted]:
    """The same recording under a gravity, all steps done."""

    @cache
    def arm(mounting: str) -> Mounted:
        return Mounted(ur5, MOUNTINGS[mounting], tmp_path_factory.mktemp(mounting))

    return arm


@pytest.fixture(params=MOUNTINGS)
def mounted(request: pytest.FixtureRequest, arm: Callable[[str], Mounted]) -> Mounted:
    return arm(request.param)


def test_the_sensor_tells_its_bias_and_its_tool(mounted: Mounted) -> None:
    found = mounted.beside_sensor
    assert found.offset_doubt is found.mounting_doubt is None
    assert found.offset is not None
    off = np.abs(found.offset.bias - ForceSensor().bias)
    assert off[:3].max() < 0.2
    assert off[3:].max() < 0.01
    assert found.offset.mass == pytest.approx(1.0, abs=0.02)
    np.testing.assert_allclose(found.offset.moment_arm, LEVER, atol=1e-3)


def test_the_imu_tells_its_mounting_and_no_tilt(mounted: Mounted) -> None:
    found, plan = mounted.calibration["all"], Imu()
    np.testing.assert_allclose(found.mounting, np.deg2rad(plan.mounting_deg), atol=1e-3)
    np.testing.assert_allclose(found.tilt, 0, atol=1e-3)
    np.testing.assert_allclose(found.gyroscope_bias, plan.gyroscope_bias, atol=1e-3)
    bias = mounted.beside_imu.accelerometer_bias
    np.testing.assert_allclose(bias, plan.accelerometer_bias, atol=0.01)


def test_joints_and_imu_tell_one_motion(mounted: Mounted) -> None:
    bias = mounted.fused.accelerometer_bias
    np.testing.assert_allclose(bias[-1], Imu().accelerometer_bias, atol=0.02)
    for estimate in ("encoders", "encoders+imu"):
        assert max(mounted.beside_imu.errors[estimate].mae.values()) < 0.02


def test_sensor_and_currents_tell_the_pushes(
    mounted: Mounted, arm: Callable[[str], Mounted]
) -> None:
    """The currents' ripple moves what they tell by newtons, but under any gravity alike."""
    floor, time = arm("floor"), mounted.known.signals.time
    true = mounted.truth.at(time).wrench[:, :3]
    for peak, force in PUSHES.items():
        during = np.abs(time - peak) < 0.2
        mean = true[during].mean(axis=0)
        np.testing.assert_allclose(mean, force, atol=2)
        for estimate, off in ((Mounted.by_sensor, 0.5), (Mounted.by_currents, 8.0)):
            own, upright = (estimate(made)[during].mean(axis=0) for made in (mounted, floor))
            np.testing.assert_allclose(own, mean, atol=off)
            np.testing.assert_allclose(own, upright, atol=0.4)


def test_a_judged_recording_has_rows_of_the_tables_of_recordings(
    arm: Callable[[str], Mounted],
) -> None:
    """But of findings, which `make_tables` words; other steps have those beside sensor and IMU."""
    judgement: Judgement = arm("floor").known.run(judge_recording)
    tables = rows_of_recordings({"made": judgement}, {}, {}, {})
    assert tables.keys() == OF_RECORDINGS.keys() - {"quality"}
    own = {name: rows["made"] for name, rows in tables.items() if "made" in rows}
    assert own.keys() | {"findings"} == vars(judgement).keys()
    assert judgement.findings
    assert judgement.payload == []  # without currents
    for name, rows in own.items():
        assert {*map(type, rows)} <= {OF_RECORDINGS[name]}, name
    assert {row.device for row in judgement.clocks} == {"force", "imu"}
    beside = arm("floor").beside
    assert {row.estimate for row in beside.innovations} == {"encoders", "encoders+imu"}
    assert {row.estimate for row in beside.errors} >= {"encoders", "encoders+imu", "filterpy"}
