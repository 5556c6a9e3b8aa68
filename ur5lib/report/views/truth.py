"""Estimates compared with the truth of simulated recordings."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.pipeline.estimators import ESTIMATES
from ur5lib.report.document import Cell
from ur5lib.report.results import NOTHING, Body, Column, Results, tabulated
from ur5lib.report.truth_table import COLUMNS

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
QUANTITIES = {
    "clock_offset": "clock offset",
    "clock_drift": "clock drift",
    "rotor_inertia": "rotor inertia",
    "base_parameter": "base parameter",
    "imu_mounting": "IMU mounting",
    "imu_tilt": "tilt of the base",
    "imu_gyroscope_bias": "gyroscope bias",
    "imu_place": "place of the IMU",
    "torque_constant": "torque constant",
    "offset": "torque offset",
    "coulomb": "Coulomb friction",
    "viscous": "viscous friction",
    "load": "load-dependent friction",
    "periodic_1_cos": "periodic friction, cosine",
    "periodic_1_sin": "periodic friction, sine",
}


def summary(results: Results) -> Body:
    """Return how many stated intervals contain the truth, by quantity."""
    truth = _truth(results)
    stated = truth[truth["within95"].notna()]
    rows = [
        [Cell(QUANTITIES[quantity]), Cell(str(len(part))), Cell(str((part == "yes").sum()))]
        for quantity, part in stated.groupby("quantity", sort=False)["within95"]
    ]
    return Body(["quantity", "values", "inside"], rows)


def fitted(results: Results) -> Body:
    """Return the values fitted to several recordings."""
    single = _truth(results, *QUANTITIES)
    arms = single["recording"].isna() & (single["quantity"] != "base_parameter")
    return _values(single[arms], "robot")


def clocks(results: Results) -> Body:
    """Return the devices' clocks."""
    single = _truth(results, *QUANTITIES)
    return _values(single[single["recording"].notna()], "recording")


def _values(rows: pd.DataFrame, owner: str) -> Body:
    """Return estimates beside the truth; owner: the column "robot" or "recording"."""
    columns: dict[str, Column] = {
        owner: owner,
        "quantity": lambda row: QUANTITIES[row.quantity],
        "of": "place",
        "unit": "unit",
        "truth": lambda row: _figure(row.truth, 5),
        "estimate": lambda row: _figure(row.estimate, 5),
        "standard error": lambda row: _figure(row.std_error, 3),
        "inside": lambda row: row.within95 if pd.notna(row.within95) else "–",
    }
    return tabulated(rows.rename(columns={"index": "place"}).itertuples(), columns)


def joint_accelerations(results: Results) -> Body:
    """Return the RMSE of joint accelerations."""
    return _series(results, "joint_acceleration_rmse", "joint")


def joint_acceleration_bands(results: Results) -> Body:
    """Return the share of joint accelerations within two stated standard deviations."""
    return _series(results, "joint_acceleration_inside_2_std", "joint")


def end_effector_accelerations(results: Results) -> Body:
    """Return the RMSE of the end effector's acceleration."""
    return _series(results, "end_effector_acceleration_rmse")


def torques(results: Results) -> Body:
    """Return the RMSE of each model's torque at the true motion."""
    return _series(results, "torque_rmse", "joint")


def wrenches(results: Results) -> Body:
    """Return the mean absolute error of the contact wrench."""
    return _series(results, "wrench_mae")


def wrench_bands(results: Results) -> Body:
    """Return the share of the contact wrench inside the stated band."""
    return _series(results, "wrench_coverage95")


def _truth(results: Results, *quantities: str) -> pd.DataFrame:
    """Return the rows of truth.csv with these quantities, none where nothing was simulated."""
    truth = results.tables.get("truth", pd.DataFrame(columns=COLUMNS))
    return truth[truth["quantity"].isin(quantities)] if quantities else truth


def _series(results: Results, quantity: str, name: str = "") -> Body:
    """Return one line for each recording and estimate."""
    rows = _truth(results, quantity)
    if rows.empty:
        return NOTHING
    header = ["recording", "estimate", *(f"{name} {i}".strip() for i in rows["index"].unique())]
    groups = rows.groupby("recording", sort=False)
    return Body(header, [line for key, part in groups for line in _lines(str(key), part)])


def _lines(recording: str, rows: pd.DataFrame) -> Iterator[list[Cell]]:
    for method, part in rows.groupby("method", sort=False):
        label = ESTIMATES.get(str(method), str(method))
        yield [Cell(recording), Cell(label), *map(_figure, part["estimate"])]
    if part["zero"].notna().any():
        yield [Cell(recording), Cell("zero"), *map(_figure, part["zero"])]


def _figure(value: float, digits: int = 3) -> Cell:
    """Return a number with some significant digits, or a dash where there is none."""
    if pd.isna(value):
        return Cell("–")
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    power = f"·10{str(int(exponent)).translate(SUPERSCRIPTS)}" if exponent else ""
    return Cell(mantissa.replace("-", "−") + power)
