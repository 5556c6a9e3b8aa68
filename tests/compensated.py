"""A force sensor's reading, compensated by the formula that `ur5 export --format sensor` writes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from ur5lib.finished import FinishedStudy
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.end_effector import point_acceleration
from ur5lib.timeseries.arrays import Array


def check_formula(text: str, results: Path, name: str) -> dict[str, Any]:
    """It gives the columns `compensated_*` of a recording, whose part of the file is returned."""
    (known,) = [one for one in json.loads(text)["recordings"] if one["recording"] == name]
    study = FinishedStudy(results)
    expected = study.sensor(name).filter(like="compensated_")
    np.testing.assert_allclose(by_formula(known, study, name), expected, rtol=1e-9, atol=1e-9)
    return known


def by_formula(known: dict[str, Any], study: FinishedStudy, name: str) -> Array:
    """The wrench of a contact (N, 6), symbols as in docs/exports.md."""
    signals, motion = study.record(Signals, name), study.record(Motion, name)
    kinematics = study.record(Kinematics, name)
    R, J = kinematics.rotation, kinematics.jacobian
    moved = point_acceleration(R, J, motion.qd, motion.qdd, np.array(known["pull_at"]))
    a, alpha = moved[:, :3], in_frame(R, moved[:, 3:])
    omega = in_frame(R, np.matvec(J[:, 3:], motion.qd))
    T = Rotation.from_rotvec(known["turn_deg"], degrees=True).as_matrix()
    xx, yy, zz, xy, xz, yz = known["inertia"] or [0.0] * 6
    I = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])  # noqa: E741
    # f6 = T f - bias_F - mass p
    # n6 = T n - bias_n - first_moment x p + I alpha + omega x (I omega)
    p = averaged(in_frame(R, known["gravity"] - a), signals, known["clock_std"])
    spun = averaged(alpha @ I + np.cross(omega, omega @ I), signals, known["clock_std"])
    bias = values(known["bias"])
    f6 = signals.force_sensor[:, :3] @ T.T - bias[:3] - values({"": known["mass"]}) * p
    n6 = signals.force_sensor[:, 3:] @ T.T - bias[3:] - np.cross(values(known["first_moment"]), p)
    n6 += spun
    # F = R f6, M = R (n6 + position x f6)
    moment = n6 + np.cross(known["position"], f6)
    return np.concatenate([np.matvec(R, f6), np.matvec(R, moment)], axis=1)


def values(intervals: dict[str, dict[str, float] | None]) -> Array:
    """null counts as 0."""
    return np.array([one["value"] if one else 0.0 for one in intervals.values()])


def in_frame(R: Array, vectors: Array) -> Array:
    return np.matvec(R.mT, vectors)


def averaged(vectors: Array, signals: Signals, std: float) -> Array:
    if std < 0.1 * signals.period:
        return vectors
    smooth = {"sigma": std / signals.period, "axis": 0, "mode": "nearest"}
    parts = [signals.segment == k for k in np.unique(signals.segment)]
    return np.concatenate([gaussian_filter1d(vectors[part], **smooth) for part in parts])
