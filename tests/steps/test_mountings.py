"""On floor, ceiling and slope alike, the steps find tool, biases, tilt and forces."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.scripts.conftest import script
from ur5lib.identification.current_samples import current_record
from ur5lib.lab.stand.plan import ForceSensor, Imu
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.records.motion import FusedMotion, Motion
from ur5lib.records.signals import Signals
from ur5lib.records.truth import Truth
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.study.reading import parse_study
from ur5lib.tables import read_json
from ur5lib.thesis.current_based import wrench_from_torque
from ur5lib.timeseries.arrays import Array

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
ARM = robot_path("ur5")
TABLES = (
    "robot force imu kinematics signals motion noise fused accelerations torques "
    "forces published sensor truth"
)
SUMMARIES = "quality clocks calibration"
SETTINGS: dict[str, Any] = {
    "order": 4,
    "cutoff_hz": 2.0,
    "max_gap_s": 0.1,
    "bias_window_s": 1.0,
    "mounting": (None, None),
    "min_singular_value": 0.01,
}


class Mounted:
    """A recording of an arm that hangs somewhere, and what the steps make of it."""

    def __init__(self, gravity: list[float] | None, folder: Path) -> None:
        made: dict[str, Any] = {"name": "made", "robot": "ur5", "format": "thesis-csv"}
        made |= {"role": "fit", "gravity": gravity, "simulate": PLAN}
        study = parse_study({"study": "made", "title": "Made", "recordings": [made]}, "made.yaml")
        recording: Any = study.recordings[0]
        entry = recording.model_copy(update={"folder": f"{folder}/raw"})
        self.folder = folder
        self.params = SETTINGS | {
            "format": recording.format,
            "plan": recording.simulate.model_dump_json(),
            "recording": entry.model_dump_json(),
            "gravity": gravity,
            "payload": recording.known_payload().model_dump_json(),
            "tcp": [],
            "role": recording.role,
        }
        self.files: dict[str, Any] = {n: f"{folder}/{n}.parquet" for n in TABLES.split()}
        self.files |= {name: f"{folder}/{name}.json" for name in SUMMARIES.split()}
        self.files["raw"] = [f"{folder}/raw/{file}" for file in recording.file_names()]

    def run(self, step: str, files: dict[str, Any] | None = None, **params: Any) -> None:
        """A step on the files of the folder, each under the name by which its rule has it."""
        more = {"summary": f"{self.folder}/{step}.json", "arm": ARM} | (files or {})
        paths = SimpleNamespace(**self.files | more)
        getattr(script(step), step)(paths, paths, SimpleNamespace(**self.params | params))

    def run_all(self) -> None:
        """All that has to do with gravity, and what leads there.

        The IMU is calibrated on the motion itself, as if that were another recording.
        """
        for step in ("simulate_recording", "repair_frames", "compute_kinematics"):
            self.run(step)
        self.run("estimate_clocks")
        self.run("align_signals")
        own = {name: [self.files[name]] for name in ("signals", "kinematics", "clocks")}
        gravity = [self.params["gravity"]]
        self.run("calibrate_imu", own, recordings=["other"], gravities=gravity)
        self.run("smooth_motion")
        account = {"account": f"{self.folder}/smooth_motion.json"}
        self.run("fuse_imu", account, recording="made")
        self.run("compare_accelerations")
        self.run("compute_torques")
        grid = {"time": self.signals.time, "segment": self.signals.segment}
        Forces(**grid).write(self.files["forces"])
        PublishedForces(**grid).write(self.files["published"])
        self.run("compare_forces")

    @property
    def signals(self) -> Signals:
        return Signals.read(self.files["signals"])

    def summary(self, step: str) -> Any:
        return read_json(f"{self.folder}/{step}.json")

    def by_sensor(self) -> Array:
        """Contact force (N, 3) [N], less bias and the tool's weight."""
        return SensorWrenches.read(self.files["sensor"]).wrench["compensated"][:, :3]

    def by_currents(self) -> Array:
        """Contact force (N, 3) [N] by what currents, link model and known payload leave."""
        motion, torques = Motion.read(self.files["motion"]), Torques.read(self.files["torques"])
        model = load_robot(ARM).fullest_model()
        record = current_record("made", self.signals, motion, torques, model)
        assert record is not None
        constant = np.array(self.summary("truth")["drive"]["torque_constant"])
        jacobian = Kinematics.read(self.files["kinematics"]).jacobian
        external, least = record.torque - constant * record.current, SETTINGS["min_singular_value"]
        return wrench_from_torque(jacobian, external, least)[:, :3]


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Mounted]:
    """The same recording under a gravity, all steps done."""

    @cache
    def arm(mounting: str) -> Mounted:
        made = Mounted(MOUNTINGS[mounting], tmp_path_factory.mktemp(mounting))
        made.run_all()
        return made

    return arm


@pytest.fixture(params=MOUNTINGS)
def mounted(request: pytest.FixtureRequest, arm: Callable[[str], Mounted]) -> Mounted:
    return arm(request.param)


def test_the_sensor_tells_its_bias_and_its_tool(mounted: Mounted) -> None:
    found = mounted.summary("compare_forces")
    assert found["offset_doubt"] is found["mounting_doubt"] is None
    off = np.abs(np.array(found["offset"]["bias"]) - ForceSensor().bias)
    assert off[:3].max() < 0.2
    assert off[3:].max() < 0.01
    assert found["offset"]["mass"] == pytest.approx(1.0, abs=0.02)
    np.testing.assert_allclose(found["offset"]["moment_arm"], LEVER, atol=1e-3)


def test_the_imu_tells_its_mounting_and_no_tilt(mounted: Mounted) -> None:
    found, plan = read_json(mounted.files["calibration"])["all"], Imu()
    np.testing.assert_allclose(found["mounting"], np.deg2rad(plan.mounting_deg), atol=1e-3)
    np.testing.assert_allclose(found["tilt"], 0, atol=1e-3)
    np.testing.assert_allclose(found["gyroscope_bias"], plan.gyroscope_bias, atol=1e-3)
    bias = mounted.summary("compare_accelerations")["accelerometer_bias"]
    np.testing.assert_allclose(bias, plan.accelerometer_bias, atol=0.01)


def test_joints_and_imu_tell_one_motion(mounted: Mounted) -> None:
    bias = FusedMotion.read(mounted.files["fused"]).accelerometer_bias
    np.testing.assert_allclose(bias[-1], Imu().accelerometer_bias, atol=0.02)
    errors = mounted.summary("compare_accelerations")["errors"]
    for estimate in ("encoders", "encoders+imu"):
        assert max(errors[estimate]["mae"].values()) < 0.02


def test_sensor_and_currents_tell_the_pushes(
    mounted: Mounted, arm: Callable[[str], Mounted]
) -> None:
    """The currents' ripple moves what they tell by newtons, but under any gravity alike."""
    floor, time = arm("floor"), mounted.signals.time
    true = Truth.read(mounted.files["truth"]).wrench[:, :3]
    for peak, force in PUSHES.items():
        during = np.abs(time - peak) < 0.2
        mean = true[during].mean(axis=0)
        np.testing.assert_allclose(mean, force, atol=2)
        for estimate, off in ((Mounted.by_sensor, 0.5), (Mounted.by_currents, 8.0)):
            own, upright = (estimate(made)[during].mean(axis=0) for made in (mounted, floor))
            np.testing.assert_allclose(own, mean, atol=off)
            np.testing.assert_allclose(own, upright, atol=0.4)
