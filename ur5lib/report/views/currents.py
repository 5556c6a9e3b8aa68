"""Friction, torque constants and motor currents: fits and predictions."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from ur5lib.records.friction import without_totals
from ur5lib.report.figures.thinned import by_position, by_velocity
from ur5lib.report.results import Results

CONSTANTS = ["torque_constant", "gain"]  # the parameter of currents and of measured torques
UNMOVED = "no_motion"  # the reason against a parameter of a joint that did not move


def predicted(results: Results) -> list[str]:
    """Return the validate recordings with predicted currents."""
    fitted = results.rows("current_rmse", model="fitted")["recording"]
    return results.shown(results.with_role("validate", fitted))


def constants(results: Results) -> pd.DataFrame:
    """Return torque constants, offsets and friction; moved: whether the joint moved."""
    rows = without_totals(results.tables["friction"])
    return rows.assign(moved=rows["reason"].ne(UNMOVED))


def by_joint(results: Results) -> pd.DataFrame:
    """Return the rows of `constants` with `constant_use` and `constant_reason`: whether the torque
    constant of the same joint may be used, and why not.
    """
    rows, key = constants(results), ["robot", "joint"]
    own = rows[rows["parameter"].isin(CONSTANTS)].set_index(key)[["use", "reason"]]
    return rows.join(own.add_prefix("constant_"), on=key)


def resting(results: Results) -> list[str]:
    """Return the arms that were fitted only in postures at rest."""
    moving = results.arms()
    judged = {moving[name] for name in results.tables["current_rmse"]["recording"]}
    return [robot for robot in results.tables["friction"]["robot"].unique() if robot not in judged]


def joint_remarks(results: Results) -> list[dict[str, object]]:
    """Return the remarks of the fit about joints: arm, joints and remark."""
    rows = results.tables["remarks"].dropna(subset="joint")
    groups = rows.groupby(["robot", "remark"], sort=False)["joint"]
    return [
        {"robot": robot, "joints": [*map(int, joints)], "remark": remark}
        for (robot, remark), joints in groups
    ]


def predictions(results: Results) -> pd.DataFrame:
    """Return the errors of all models on the recordings of `predicted`, or on the only recording,
    with the difference between repeated motions (`floor`).
    """
    names = predicted(results) if len(results.roles()) > 1 else [*results.roles()]
    return results.with_floor(results.rows("current_rmse", recording=names), "current")


def friction_by_velocity(results: Results) -> pd.DataFrame:
    """Return some samples of each arm's friction over velocity, its fit and band."""
    return _of_arms(results, "friction", by_velocity)


def residual_by_position(results: Results) -> pd.DataFrame:
    """Return the quartiles of each arm's residuals over position."""
    return _of_arms(results, "residuals", by_position)


def _of_arms(
    results: Results, figure: str, thinned: Callable[[Path], pd.DataFrame]
) -> pd.DataFrame:
    """Return the numbers of each arm's figure, thinned, with the arm's name; thinned: function that
    reads a file of numbers.
    """
    paths = {robot: results.figures / robot / f"{figure}.csv" for robot in results.robots()}
    parts = [thinned(path).assign(robot=robot) for robot, path in paths.items()]
    return pd.concat([part for part in parts if len(part)] or [pd.DataFrame()])
