"""The report's section on estimates beside the truth, which simulated recordings have."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.document import Block, Cell, Paragraph, Table
from ur5lib.report.truth_table import INSIDE2

INTRODUCTION = (
    "The virtual test stand simulates the arm in MuJoCo, an engine that shares no code with the "
    "one under test, and keeps what truly happened. No step read it but the one that made these "
    "tables. “Inside” tells whether the truth lies in the stated 95 % interval; “zero” is the "
    "error of an estimate that always says zero. Targets and torques of the controller have no "
    "noise, as real ones have none: what is fitted to them errs by their sixth decimal alone."
)
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
QUANTITIES = {
    "clock_offset": "clock offset",
    "clock_drift": "clock drift",
    "rotor_inertia": "rotor inertia",
    "base_parameter": "base parameter",
    "imu_mounting": "IMU mounting",
    "imu_tilt": "tilt of the base",
    "imu_gyroscope_bias": "gyroscope bias",
    "torque_constant": "torque constant",
    "offset": "torque offset",
    "coulomb": "Coulomb friction",
    "viscous": "viscous friction",
    "load": "load-dependent friction",
    "periodic_1_cos": "periodic friction, cosine",
    "periodic_1_sin": "periodic friction, sine",
}
SERIES = {  # quantity: what it is, and how an index of it is called
    "joint_acceleration_rmse": ("RMSE of joint accelerations [rad/s²]", "joint"),
    "joint_acceleration_inside_2_std": (
        f"Share of joint accelerations inside two stated standard deviations ({INSIDE2:.2f} if "
        "these are right)",
        "joint",
    ),
    "end_effector_acceleration_rmse": (
        "RMSE of the end effector's acceleration at the IMU [m/s², rad/s²], low-passed as the "
        "estimates are",
        "",
    ),
    "torque_rmse": ("RMSE of each model's torque at the true motion [Nm]", "joint"),
    "wrench_rmse": ("RMSE of the contact wrench [N, Nm]", ""),
    "wrench_mae": ("Mean absolute error of the contact wrench [N, Nm]", ""),
    "wrench_coverage95": ("Share of the contact wrench inside the stated 95 % band", ""),
}


def truth_findings(truth: pd.DataFrame) -> list[str]:
    """How many stated intervals hold the truth, in one sentence. truth: the table of this name."""
    stated = truth["within95"].dropna()
    return [
        f"Of {len(stated)} values with a stated 95 % interval, {(stated == 'yes').sum()} intervals "
        "hold the truth of the simulation."
    ]


def truth_blocks(truth: pd.DataFrame) -> list[Block]:
    """truth: the table of this name."""
    blocks: list[Block] = [Paragraph(INTRODUCTION), _summary(truth)]
    single = truth[truth["quantity"].isin(QUANTITIES)]
    arms = single[single["recording"].isna() & (single["quantity"] != "base_parameter")]
    clocks = single[single["recording"].notna()]
    blocks += [_values(arms, "robot", "What was fitted to several recordings")] if len(arms) else []
    blocks += [_values(clocks, "recording", "The devices' clocks")] if len(clocks) else []
    return [*blocks, *_series(truth)]


def _summary(truth: pd.DataFrame) -> Table:
    """How many stated intervals hold the truth, quantity by quantity."""
    stated = truth[truth["within95"].notna()]
    rows = [
        [Cell(QUANTITIES[quantity]), Cell(str(len(part))), Cell(str((part == "yes").sum()))]
        for quantity, part in stated.groupby("quantity", sort=False)["within95"]
    ]
    caption = "Values whose stated 95 % interval holds the truth."
    return Table(caption, ["quantity", "values", "inside"], rows)


def _values(rows: pd.DataFrame, of: str, what: str) -> Table:
    body = [
        [
            Cell(row[of]),
            Cell(QUANTITIES[row["quantity"]]),
            Cell(str(row["index"])),
            Cell(row["unit"]),
            _figure(row["truth"], 5),
            _figure(row["estimate"], 5),
            _figure(row["std_error"], 3),
            Cell(row["within95"] if pd.notna(row["within95"]) else "–"),
        ]
        for _, row in rows.iterrows()
    ]
    header = [of, "quantity", "of", "unit", "truth", "estimate", "standard error", "inside"]
    return Table(f"{what}, beside the truth.", header, body)


def _series(truth: pd.DataFrame) -> Iterator[Table]:
    """A table for each kind of series, a line for each recording and estimate."""
    for quantity, (what, name) in SERIES.items():
        rows = truth[truth["quantity"] == quantity]
        if len(rows):
            index = rows["index"].unique()
            header = ["recording", "estimate", *(f"{name} {i}".strip() for i in index)]
            body = [
                line
                for key, part in rows.groupby("recording", sort=False)
                for line in _lines(str(key), part)
            ]
            yield Table(f"{what}.", header, body)


def _lines(recording: str, rows: pd.DataFrame) -> Iterator[list[Cell]]:
    for method, part in rows.groupby("method", sort=False):
        yield [Cell(recording), Cell(str(method)), *map(_figure, part["estimate"])]
    if part["zero"].notna().any():
        yield [Cell(recording), Cell("zero"), *map(_figure, part["zero"])]


def _figure(value: float, digits: int = 3) -> Cell:
    """A number of any size to some digits, or a dash where there is none."""
    if pd.isna(value):
        return Cell("–")
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    power = f"·10{str(int(exponent)).translate(SUPERSCRIPTS)}" if exponent else ""
    return Cell(mantissa.replace("-", "−") + power)
