"""A model's predictions of motion without contact, as frames: efforts, their errors, friction."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.chain.recordings import frame_of
from ur5lib.chain.steps import Files
from ur5lib.errors import InputError, briefly
from ur5lib.jobs.memory import record_of
from ur5lib.records.friction import Friction
from ur5lib.records.judgement import CurrentError, current_errors
from ur5lib.records.prediction import Prediction
from ur5lib.records.units import column_units
from ur5lib.tables import as_written, columns, table_by_owner
from ur5lib.timeseries.arrays import Array


def beside_measured(own: Files, friction: Friction) -> pd.DataFrame:
    """Return a recording's predicted and measured efforts, residuals and external torque.

    (N, n) each, by `time`; own: its files after `predict_currents`.
    """
    effort, count = friction.measured, len(friction.fit.joints)
    name, unit = effort.quantity, effort.unit
    measured = frame_of(own["signals"], columns(effort.channel, count))
    stated = [*columns(f"predicted_{name}", count), *columns(f"{name}_band", count)]
    frame = frame_of(own["currents"], [*stated, *columns("tau_ext", count)])
    left = measured.to_numpy() - frame[stated[:count]].to_numpy()
    names = columns(f"residual_{name}", count)
    parts = [frame[stated], measured, pd.DataFrame(left, frame.index, names)]
    joined = pd.concat([*parts, frame.drop(columns=stated)], axis="columns")
    joined.attrs["units"] = frame.attrs["units"] | dict.fromkeys([*measured, *names], unit)
    return joined


def errors(moving: Mapping[str, Files], friction: Friction) -> pd.DataFrame:
    """Return the rows of the table `current_rmse` for recordings, each with `nrmse`, its RMSE over
    that of a constant current.
    """
    rows = {
        name: current_errors(record_of(Prediction, own["prediction"]))
        for name, own in moving.items()
    }
    table = as_written(table_by_owner(CurrentError, rows))
    share = table["rmse_lowpassed"] / table["zero_rmse_lowpassed"]
    table.insert([*table].index("joint") + 1, "nrmse", share)
    table.attrs["units"] = column_units(
        "current_rmse", table.columns.drop("nrmse"), friction.measured.unit
    )
    return table


def friction_at(friction: Friction, velocity: object, load: object) -> pd.DataFrame:
    """Return the friction of each joint and its standard error by velocity; see `Model.friction`
    for velocity, load and columns.

    Raises InputError if these are no numbers, or not as many as joints.
    """
    from ur5lib.identification.steady_friction import steady_friction  # scipy loads for a while

    joints = friction.fit.joints
    qd = np.atleast_1d(numbers("velocity", velocity, "rad/s", len(joints)))
    rows = qd if qd.ndim == 2 else np.repeat(qd[:, None], len(joints), axis=1)
    loads = np.broadcast_to(_loads(load, rows), rows.shape)
    each = zip(joints, rows.T, loads.T, strict=True)
    values, stds = zip(*(steady_friction(*one) for one in each), strict=True)
    names = [name for of in ("", "_std") for name in columns(f"tau_friction{of}", len(joints))]
    index = pd.RangeIndex(len(qd), name="row") if qd.ndim == 2 else pd.Index(qd, name="velocity")
    frame = pd.DataFrame(np.array([*values, *stds]).T, index, names)
    units = {} if qd.ndim == 2 else {"velocity": "rad/s"}
    frame.attrs["units"] = units | dict.fromkeys(names, "Nm")
    return frame


def _loads(load: object, rows: Array) -> Array:
    """Return the loads [Nm] of rows (N, n) of velocities: one, (n,) by joint, or (N, n)."""
    found = numbers("load", load, "Nm", rows.shape[1])
    if found.ndim and found.shape not in (rows.shape[1:], rows.shape):
        raise InputError(f"load has {found.size} numbers; give one, or {rows.shape[1]}, by joint")
    return found


def numbers(name: str, given: Any, unit: str, joints: int) -> Array:
    """Return a given number, a row of numbers, or rows with one by joint, as an array () , (M,) or
    (N, n). Raises InputError for anything else; name, unit: of the numbers, for the message.
    """
    try:
        found = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.ndim > 2 or not found.size or not np.isfinite(found).all():
        raise InputError(f"{name}: {briefly(given)}; give a number, or several in a row [{unit}]")
    if found.ndim == 2 and found.shape[1] != joints:
        raise InputError(
            f"{name} has the shape {found.shape}, but the arm {joints} joints; give one row, or "
            f"(N, {joints}) [{unit}]"
        )
    return found


def expect_predicted(moving: Mapping[str, Files], friction: Friction) -> None:
    """Raise InputError that names the recordings for which no effort was predicted, if there are
    any.
    """
    without = [
        name for name, own in moving.items() if not record_of(Prediction, own["prediction"]).scores
    ]
    if without:
        raise InputError(
            f"{', '.join(without)}: no {friction.effort} is predicted; record it, in steps no "
            "longer than those of the fit"
        )
