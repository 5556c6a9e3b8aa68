"""End effector's accelerations compared with the IMU, its calibration, tests of the smoother."""

from collections.abc import Iterator

import numpy as np

from ur5lib.report.cells import listed, number, signed, with_error
from ur5lib.report.document import Cell
from ur5lib.report.results import NOTHING, Body, Column, Results, tabulated
from ur5lib.report.sentences import Sentence, say

COMPONENTS = {"x": "m/s²", "y": "m/s²", "z": "m/s²", "rx": "rad/s²", "ry": "rad/s²", "rz": "rad/s²"}


def drawn(results: Results) -> list[str]:
    """Return the recordings whose acceleration is drawn: with printed errors, or the first."""
    return results.shown(printed(results)) or results.shown(
        [*results.tables["acceleration_mae"]["recording"]], 1
    )


def printed(results: Results) -> list[str]:
    """Return the recordings with printed errors."""
    return results.printed("acceleration_mae")


def filtered_first(results: Results) -> list[str]:
    """Return the recordings whose IMU is drawn filtered before rotation, as printed errors need."""
    file = "accelerations_filtered_first.svg"
    return [name for name in printed(results) if (results.figures / name / file).is_file()]


def errors(results: Results) -> Body:
    """Return the errors with and without IMU, and of zero, for recordings with a valid IMU."""
    rows = results.tables["acceleration_mae"]
    body = []
    for recording, part in rows[~rows["estimate"].str.startswith("euler")].groupby(
        "recording", sort=False
    ):
        for estimate, values in part.groupby("estimate", sort=False):
            body.append([Cell(recording), Cell(estimate), *(number(x, 4) for x in values["mae"])])
        zero = [number(x, 4) for x in values["zero_mae"]]
        body.append([Cell(recording), Cell("zero"), *zero])
    header = [f"{name} [{unit}]" for name, unit in COMPONENTS.items()]
    return Body(["recording", "estimate", *header], body)


def printed_errors(results: Results, recording: str) -> Body:
    """Return Table 5.7: printed, rebuilt, and their difference."""
    rows = results.rows("acceleration_mae", recording=recording)
    columns: dict[str, Column] = {
        "component": lambda row: f"{row.component} [{COMPONENTS[row.component]}]",
        "printed": lambda row: number(row.printed, 4),
        "rebuilt": lambda row: number(row.mae, 4),
        "diff.": lambda row: signed(100 * (row.mae / row.printed - 1), 1, " %"),
    }
    return tabulated(rows[rows["printed"].notna()].itertuples(), columns)


def beside_imu(results: Results) -> Iterator[Sentence]:
    """Report the error of the encoders against the IMU, averaged over recordings with one."""
    rows = results.rows("acceleration_mae", estimate="encoders")
    if len(rows):
        mean = rows.groupby("component", sort=False)[["mae", "zero_mae"]].mean()
        errors, count = mean[:3], rows["recording"].nunique()
        yield say("motion.beside imu", mae=errors["mae"], zero=errors["zero_mae"], count=count)


def bands(results: Results) -> Body:
    """Return the differences from the IMU, the share within their bands, and those of filterpy."""
    table = results.tables["acceleration_bands"]
    body = []
    for (name, state), rows in table.groupby(["range", "during"], sort=False):
        by_component = rows.groupby("component", sort=False)
        linear, angular = slice(0, 3), slice(3, 6)
        rms, plain = (
            np.sqrt(by_component[column].apply(lambda x: np.mean(x**2)))
            for column in ("rms", "filterpy_rms")
        )
        held = 100 * by_component["held"].mean()
        parts = [listed(values[part], digits) for values, digits, part in (
            (rms, 3, linear), (held, 0, linear), (plain, 3, linear),
            (rms, 3, angular), (held, 0, angular), (plain, 3, angular),
        )]  # fmt: skip
        body.append([Cell(name), Cell(state), *map(Cell, parts)])
    header = [
        "frequency",
        "arm",
        "difference x, y, z [m/s²]",
        "in band [%]",
        "filterpy",
        "difference rx, ry, rz [rad/s²]",
        "in band [%]",
        "filterpy",
    ]
    return Body(header, body) if body else NOTHING


def calibration(results: Results) -> Body:
    """Return the IMU's mounting and place, the base's tilt and the gyroscope's bias."""
    columns: dict[str, Column] = {
        "arm": "robot",
        "quantity": lambda row: row.quantity.replace("_", " "),
        "axis": "axis",
        "value": lambda row: with_error(row.value, row.std_error, 5),
        "described": lambda row: number(row.described, 5),
        "unit": "unit",
    }
    return tabulated(results.tables["imu_calibration"].itertuples(), columns)


def place(results: Results) -> Iterator[Sentence]:
    """Report how far the IMU is from its described place, and which of the two is used."""
    table = results.tables["imu_calibration"]
    for arm, rows in table[table["quantity"] == "place"].groupby("robot", sort=False):
        off = 1e3 * (rows["value"] - rows["described"])
        parts = [
            say("motion.apart", by=by, std=1e3 * std)
            for by, std in zip(off, rows["std_error"], strict=True)
        ]
        yield say("motion.place", arm=arm, off=parts, ratio=rows["held_out"].iloc[0])


def innovations(results: Results) -> Iterator[Sentence]:
    """Report how many channels pass the tests of the innovations."""
    table = results.tables["innovations"]
    parts = []
    for estimate, rows in table.groupby("estimate", sort=False):
        passed = {test: int((rows[test] == "yes").sum()) for test in ("consistent", "white")}
        parts.append(say("motion.tested", estimate=estimate, count=len(rows), **passed))
    if parts:
        widest, coloured = np.sqrt(table["colour"]).max(), (table["white"] == "no").any()
        yield say("motion.innovations", parts=parts, widest=widest, coloured=coloured)
