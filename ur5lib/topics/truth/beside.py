"""Rows of estimates compared with the truth of simulations."""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import t

from ur5lib.records.clocks import ClockRelation
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.models import Rotors
from ur5lib.records.table import WRENCH, WRENCH_UNITS
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.stand.plan import Imu
from ur5lib.stand.truth import TrueDrive, TrueParameters, Truth
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import coverage, mean_absolute_error

Row = dict[Hashable, Any]
COLUMNS = [  # these are the columns of truth.csv
    *("recording", "robot", "quantity", "method", "index", "unit"),
    *("truth", "estimate", "std_error", "within95", "zero"),
]
AXIS_NAMES = ["x", "y", "z"]
JACKKNIFE_PARTS = 8  # a single recording is split into this many for a jackknife


def rows(
    quantity: str, index: Sequence[object], unit: Any, truth: Any, estimate: Any, **more: Any
) -> list[Row]:
    """Return a row for each joint, axis, component or device of `index`.

    unit, truth, estimate, and each of `more`: one value for all rows, or a value for each.
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
    """Return a row for each estimated value; within95: is the truth in its 95 % interval?

    truth, estimate, std: (n,); estimate: NaN for a joint that did not move; std: NaN if not stated,
    then the row has no std and no within95; freedom: degrees of freedom of the errors.
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
    """Return a row for each column of a series (N, M): its RMSE, and the RMSE of zero."""
    finite = np.isfinite(estimate).all(axis=1) & np.isfinite(truth).all(axis=1)
    off, zero = (
        np.sqrt(np.mean(array[finite] ** 2, axis=0)) for array in (estimate - truth, truth)
    )
    return rows(f"{quantity}_rmse", index, unit, 0.0, off, zero=zero, method=method)


def clock_rows(clocks: Mapping[str, ClockRelation], truth: TrueParameters) -> Iterator[Row]:
    """Yield estimated offset [s] and drift [ppm] of each device's clock, compared with the true
    ones.

    Sensors aligned by the host's stamps use the robot's clock: their drift has no truth.
    """
    for device, clock in clocks.items():
        true, drift_std = truth.clocks[device], clock.drift_std or 0.0
        numbers = [true["offset_s"]], [clock.offset], [clock.offset_std]
        rows_of_device = values("clock_offset", [device], "s", *numbers)
        if clock.drift is not None and "drift_ppm" in true:
            numbers = [true["drift_ppm"]], [1e6 * clock.drift], [1e6 * drift_std]
            rows_of_device += values("clock_drift", [device], "ppm", *numbers)
        yield from (row | {"method": clock.method} for row in rows_of_device)


def wrench_rows(forces: Forces, truth: Truth) -> Iterator[Row]:
    """Yield RMSE, MAE and coverage of the 95 % band of each estimated wrench, compared with the
    true one.
    """
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
    """Yield estimated rotor inertias, compared with the true ones; truth: (n,) [kg m²].

    Standard errors: jackknife over recordings, or over JACKKNIFE_PARTS of a single one.
    """
    if rotors.value is not None and rotors.std_error is not None:
        numbers = truth, rotors.value.inertia, rotors.std_error.inertia
        freedom = len(rotors.from_) - 1 or JACKKNIFE_PARTS - 1
        yield from values("rotor_inertia", joint_numbers(truth), "kg m2", *numbers, freedom)


def imu_rows(calibration: ImuCalibration, imu: Imu) -> Iterator[Row]:
    """Yield estimated mounting, tilt of the base, gyroscope bias and place of the IMU, compared
    with the true ones.

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
    """Yield estimated torque constants and friction, compared with the true ones; true: simulated
    parameters by name.

    within95 uses the reported intervals (Student's t for few recordings). Fitted terms that the
    test stand's friction does not have are left out.
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
