"""Estimates from simulated recordings against the truth, which no other step reads."""

from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
import pandas as pd
from scipy.stats import norm, t

from ur5lib.dynamics.flange import point_acceleration
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.records.accelerations import COMPONENTS, Accelerations
from ur5lib.records.clocks import SettledClock
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.motion import Alignment, FusedMotion, Motion
from ur5lib.records.table import WRENCH, WRENCH_UNITS
from ur5lib.records.truth import COLUMNS, TrueDrive, TrueParameters, Truth
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.stand.plan import Imu
from ur5lib.tables import json_text, read_record
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, inner_lowpass
from ur5lib.timeseries.metrics import coverage, mean_absolute_error
from ur5lib.timeseries.segments import by_segment

Row = dict[Hashable, Any]
Truths = Mapping[str, TrueParameters]  # by recording
TruthPart = TypeVar("TruthPart")
AXIS_NAMES = ["x", "y", "z"]
JACKKNIFE_PARTS = 8  # of an only recording, in a jackknife
SHARE_WITHIN_2_STD = float(norm.cdf(2) - norm.cdf(-2))


def compare_with_truth(
    truth: list[Path],
    truth_summary: list[Path],
    recordings: list[str],
    alignment: Mapping[str, Alignment],
    motion: Mapping[str, Motion],
    fused: Mapping[str, FusedMotion],
    accelerations: Mapping[str, Accelerations],
    forces: Mapping[str, Forces],
    described: Mapping[str, Robot],
    fitted: Mapping[str, Robot],
    rotors: Mapping[str, Rotors],
    identification: Mapping[str, Identification],
    calibration: Mapping[str, dict[str, ImuCalibration]],
    friction: Mapping[str, Friction],
    lowpass: Butterworth,
) -> pd.DataFrame:
    """Return the table of estimates beside the truth.

    truth, truth_summary: files of `Truth` and `TrueParameters` of the simulated recordings;
    alignment to forces: by recording, described to friction: by arm; lowpass: of the accelerations.
    """
    known = [read_record(TrueParameters, path) for path in truth_summary]
    truths = dict(zip(recordings, known, strict=True))
    paths = dict(zip(recordings, truth, strict=True))
    rows = list[Row]()
    for arm, robot in described.items():
        fits = Fits(rotors[arm], identification[arm], calibration[arm], friction[arm])
        of_arm = {name: one for name, one in truths.items() if one.robot == arm}
        rows += [{"robot": arm} | row for row in arm_rows(robot, fits, of_arm)]
    for name in forces:  # not of recordings that cannot be read
        parameters = truths[name]
        estimated = Estimated(
            alignment[name].clocks, motion[name], fused[name], accelerations[name], forces[name]
        )
        arms = described[parameters.robot], fitted[parameters.robot]
        about = {"recording": name, "robot": parameters.robot}
        samples = Truth.read(paths[name])
        found = recording_rows(estimated, *arms, parameters, samples, lowpass)
        rows += [about | row for row in found]
    return pd.DataFrame(rows, columns=COLUMNS)


class Fits(NamedTuple):
    """What was fitted to an arm."""

    rotors: Rotors
    identification: Identification
    calibration: dict[str, ImuCalibration]
    friction: Friction


class Estimated(NamedTuple):
    """What was estimated of a recording."""

    clocks: dict[str, SettledClock]
    motion: Motion
    fused: FusedMotion
    accelerations: Accelerations
    forces: Forces


def arm_rows(robot: Robot, fits: Fits, truths: Truths) -> Iterator[Row]:
    """Yield rows about parameters fitted to several recordings with a common truth.

    robot: the arm as described.
    """

    def true_rotors(truth: TrueParameters) -> Sequence[float]:
        return robot.models[truth.model].rotor_inertias or (0.0,) * len(robot.joints)

    def true_parameters(truth: TrueParameters) -> Array:
        return LinkModel(robot, truth.model).parameters  # without a payload: it is known

    rotors, identified, calibration, friction = fits
    if (inertias := shared(truths, rotors.from_, true_rotors)) is not None:
        yield from rotor_rows(rotors, inertias)
    if (true := shared(truths, identified.from_, true_parameters)) is not None:
        for row in identified.parameters:
            if row.determined:
                numbers = [float(row.weights @ true)], [row.value], [row.std_error]
                yield from values("base_parameter", [row.parameter], "", *numbers)
    imu = calibration.get("all")
    if imu and (plan := shared(truths, imu.from_, attrgetter("plan.imu"))):
        yield from imu_rows(imu, plan)
    if truth := shared(truths, friction.from_, attrgetter("drive", "friction")):
        yield from friction_rows(friction, *truth)


def recording_rows(
    estimated: Estimated,
    robot: Robot,
    fitted: Robot,
    truth: TrueParameters,
    samples: Truth,
    lowpass: Butterworth,
) -> Iterator[Row]:
    """Yield rows about one recording.

    robot, fitted: the arm as described and as fitted; lowpass: of the accelerations.
    """
    motion, fused = estimated.motion, estimated.fused
    true = samples.at(motion.time)
    exact = point_acceleration(robot, true.q, true.qd, true.qdd, np.array(robot.mounting.imu))
    acceleration = by_segment(inner_lowpass, exact, motion.segment, 1 / true.period, *lowpass)
    yield from clock_rows(estimated.clocks, truth)
    yield from joint_acceleration_rows({"encoders": motion, "encoders+imu": fused}, true)
    accelerations = estimated.accelerations
    felt = {} if accelerations.felt is None else {"imu": accelerations.felt}
    about = "end_effector_acceleration", [*COMPONENTS], [*COMPONENTS.values()]
    for method, estimate in (felt | accelerations.acceleration).items():
        yield from errors(*about, acceleration, estimate, method)
    yield from torque_rows(fitted, truth, true)
    yield from wrench_rows(estimated.forces, true)


def torque_rows(robot: Robot, truth: TrueParameters, true: Truth) -> Iterator[Row]:
    """Yield the RMSE of models' torques at the true motion, with gravity and payload as simulated,
    against those of the simulated arm.
    """
    for payload in (truth.plan.payload, truth.plan.undeclared_payload):
        robot = robot.carrying(payload)
    rigid = true.motor_torque - true.friction_torque + true.contact_torque
    for name in (robot.chosen_model, "identified"):
        if name in robot.models:
            model = LinkModel(robot.mounted(truth.gravity), name)
            torque = model.inverse_dynamics(true.q, true.qd, true.qdd)
            yield from errors("torque", joint_numbers(rigid), "Nm", rigid, torque, f"Model {name}")


def shared(
    truths: Truths, recordings: Collection[str], part: Callable[[TrueParameters], TruthPart]
) -> TruthPart | None:
    """Return a part of the truth that recordings have in common, None where they have not."""
    if not recordings or not set(recordings) <= set(truths):
        return None
    parts = [part(truths[name]) for name in recordings]
    return parts[0] if all(json_text(other) == json_text(parts[0]) for other in parts) else None


def rows(
    quantity: str, index: Sequence[object], unit: Any, truth: Any, estimate: Any, **more: Any
) -> list[Row]:
    """Return a row for each of some joints, axes, components or devices (`index`).

    Other arguments: one value for all, or a value for each.
    """
    columns = {"quantity": quantity, "index": [*index], "unit": unit, "truth": truth}
    return pd.DataFrame(columns | {"estimate": estimate} | more).to_dict("records")


def values(
    quantity: str,
    index: Sequence[object],
    unit: str,
    truth: Any,
    estimate: Any,
    std: Any,
    freedom: float = np.inf,
) -> list[Row]:
    """Return a row for each estimated value, with whether its 95 % interval contains the truth.

    truth, estimate, std: (n,), estimate NaN where there is none (a joint that did not move), std
    NaN where not stated: then the row has neither; freedom: degrees of freedom of the errors.
    """
    off, std = np.abs(np.subtract(estimate, truth)), np.asarray(std, dtype=np.float64)
    half = t.ppf(0.975, freedom) * std
    stated = np.isfinite(half)
    inside = pd.Series(off <= half).map({True: "yes", False: "no"}).where(stated)
    intervals = {"std_error": np.where(stated, std, np.nan), "within95": inside}
    candidates = rows(quantity, index, unit, truth, estimate, **intervals)
    return [row for row in candidates if not np.isnan(row["estimate"])]


def errors(
    quantity: str, index: Sequence[object], unit: Any, truth: Array, estimate: Array, method: str
) -> list[Row]:
    """Return a row for each column of a series (N, M): its RMSE, and that of zero."""
    finite = np.isfinite(estimate).all(axis=1) & np.isfinite(truth).all(axis=1)
    off, zero = (
        np.sqrt(np.mean(array[finite] ** 2, axis=0)) for array in (estimate - truth, truth)
    )
    return rows(f"{quantity}_rmse", index, unit, 0.0, off, zero=zero, method=method)


def clock_rows(clocks: Mapping[str, SettledClock], truth: TrueParameters) -> Iterator[Row]:
    """Yield offset [s] and drift [ppm] of each device.

    Sensors that were aligned by the host's stamps use the robot's clock: their drift has no truth.
    """
    for device, clock in clocks.items():
        true, drift_std = truth.clocks[device], clock.drift_std or 0.0
        numbers = [true["offset_s"]], [clock.offset], [clock.offset_std]
        rows_of_device = values("clock_offset", [device], "s", *numbers)
        if clock.drift is not None and "drift_ppm" in true:
            numbers = [true["drift_ppm"]], [1e6 * clock.drift], [1e6 * drift_std]
            rows_of_device += values("clock_drift", [device], "ppm", *numbers)
        yield from (row | {"method": clock.method} for row in rows_of_device)


def joint_acceleration_rows(motions: Mapping[str, Motion], truth: Truth) -> Iterator[Row]:
    """Yield the RMSE of q̈ by method, and the coverage of two standard deviations."""
    for method, motion in motions.items():
        if len(motion.time):
            estimate, true = motion.qdd, truth.qdd
            joints, quantity = joint_numbers(true), "joint_acceleration"
            inside = coverage(estimate, motion.qdd_std, true, SHARE_WITHIN_2_STD)
            yield from errors(quantity, joints, "rad/s2", true, estimate, method)
            quantity += "_inside_2_std"
            yield from rows(quantity, joints, "1", SHARE_WITHIN_2_STD, inside, method=method)


def wrench_rows(forces: Forces, truth: Truth) -> Iterator[Row]:
    """Yield RMSE, MAE and coverage of the 95 % band of each estimate."""
    true, of_wrench = truth.wrench, (WRENCH, WRENCH_UNITS)
    zero = mean_absolute_error(np.zeros_like(true), true)
    for method, estimate in forces.wrench.items():
        mae = mean_absolute_error(estimate, true)
        yield from errors("wrench", *of_wrench, true, estimate, method)
        yield from rows("wrench_mae", *of_wrench, 0.0, mae, zero=zero, method=method)
        if (std := forces.std.get(method)) is not None:
            covered = coverage(estimate, std, true)
            yield from rows("wrench_coverage95", WRENCH, "1", 0.95, covered, method=method)


def rotor_rows(rotors: Rotors, truth: Sequence[float]) -> Iterator[Row]:
    """Yield rotor inertias; truth: (n,) [kg m²].

    Their standard errors are a jackknife over recordings, or over parts of the only one.
    """
    if rotors.value is not None and rotors.std_error is not None:
        numbers = truth, rotors.value.inertia, rotors.std_error.inertia
        freedom = len(rotors.from_) - 1 or JACKKNIFE_PARTS - 1
        yield from values("rotor_inertia", joint_numbers(truth), "kg m2", *numbers, freedom)


def imu_rows(calibration: ImuCalibration, imu: Imu) -> Iterator[Row]:
    """Yield mounting, tilt of the base, gyroscope bias and place of the IMU.

    imu: as simulated, at the described place.
    """
    for name, unit, truth in (
        ("mounting", "rad", np.deg2rad(imu.mounting_deg)),
        ("tilt", "rad", np.zeros(2)),
        ("gyroscope_bias", "rad/s", imu.gyroscope_bias),
        ("place", "m", calibration.described),
    ):
        axes = AXIS_NAMES[: len(truth)]
        estimate, std = getattr(calibration, name), getattr(calibration, f"{name}_std")
        yield from values(f"imu_{name}", axes, unit, truth, estimate, std)


def friction_rows(friction: Friction, drive: TrueDrive, true: Mapping[str, Array]) -> Iterator[Row]:
    """Yield torque constants and friction; true: as simulated, by name.

    within95 uses the reported intervals, which are wider than normal ones for few recordings.
    Fitted terms that the stand's friction does not have are left out.
    """
    truths = {
        "torque_constant": (friction.measured.constant_unit, drive.torque_constant),
        "offset": ("Nm", 0 * drive.torque_constant if drive.offset is None else drive.offset),
        "coulomb": ("Nm", true["coulomb"]),
        "viscous": ("Nm s/rad", true["viscous"]),
        "load": ("1", true["load"]),
    }
    for row in friction.parameters:
        if row.name in truths:
            unit, of_joints = truths[row.name]
            value, (low, high) = float(of_joints[row.joint - 1]), row.interval
            inside = "yes" if low <= value <= high else "no"
            numbers = [value], [row.value], [row.std_error]
            name = friction.measured.parameter(row.name)
            for compared in values(name, [row.joint], unit, *numbers):
                yield compared | {"within95": inside}


def joint_numbers(values: Any) -> list[int]:
    """Return the numbers of the joints of values (..., n)."""
    return [*range(1, np.shape(values)[-1] + 1)]
