"""The report's section on accelerations: Table 5.7, Figures 5.14 and 5.15, the smoother."""

from pathlib import Path

import pandas as pd

from ur5lib.report.cells import number, signed
from ur5lib.report.document import Block, Cell, Paragraph, Picture, Table

INTRODUCTION = (
    "Joint motion is estimated by an extended Kalman filter and a Rauch-Tung-Striebel smoother: "
    "from the encoders alone, and together with the IMU. The acceleration of the IMU's place on "
    "the end effector, J q̈ + J̇ q̇, is compared with what the IMU felt, R a + g0; both sides are "
    "low-passed without delay. The IMU's mounting, the base's tilt and the gyroscope's bias come "
    "from other recordings without contact than the one that is judged; its clock and the "
    "accelerometer's bias are its own. “Encoders” uses nothing of the IMU's motion, "
    "“encoders+imu” does. “Euler” is the thesis's route through Euler angles, with its causal "
    "filter, clocks by their stamps and an IMU taken as it is (errata 1, 3, 4, 5). “Zero” is the "
    "error of an acceleration of zero."
)
NO_IMU = "No recording of this study has an IMU whose clock its motion tells."
PICTURES = {
    "accelerations": ("Acceleration from the joints and as the IMU felt it", "5.14"),
    "acceleration_errors": ("What the joints miss of the felt acceleration", "5.15"),
    "accelerations_published": ("The same as published: Euler angles, causal filter", "5.14"),
}
COMPONENTS = {"x": "m/s²", "y": "m/s²", "z": "m/s²", "rx": "rad/s²", "ry": "rad/s²", "rz": "rad/s²"}


def motion_blocks(
    acceleration: pd.DataFrame,
    calibration: pd.DataFrame,
    innovations: pd.DataFrame,
    figures: Path,
) -> list[Block]:
    """The tables of these names; figures: holds a folder for each recording."""
    filters = Picture(
        "Gain of the low-pass filters at 125 Hz.",
        figures / "filters.svg",
        "Gain over frequency of the study's filters, run both ways, and of the thesis's, one way.",
    )
    blocks: list[Block] = [_innovation_paragraph(innovations), filters]
    if acceleration.empty:
        return [Paragraph(NO_IMU), *blocks]
    blocks = [Paragraph(INTRODUCTION), _table(acceleration), *blocks]
    if len(calibration):
        blocks.append(_calibration_table(calibration))
    for recording, rows in acceleration.groupby("recording", sort=False):
        if rows["printed"].notna().any():
            blocks.append(_printed_table(recording, rows[rows["printed"].notna()]))
            blocks += _pictures(recording, figures / recording)
    return blocks


def _table(acceleration: pd.DataFrame) -> Table:
    """Every recording with a valid IMU: ours, with and without it, beside zero."""
    ours = acceleration[~acceleration["estimate"].str.startswith("euler")]
    body = []
    for recording, part in ours.groupby("recording", sort=False):
        for estimate, rows in part.groupby("estimate", sort=False):
            body.append([Cell(recording), Cell(estimate), *(number(x, 4) for x in rows["mae"])])
        body.append([Cell(recording), Cell("zero"), *(number(x, 4) for x in rows["zero_mae"])])
    header = ["recording", "estimate", *(f"{name} [{unit}]" for name, unit in COMPONENTS.items())]
    caption = "Mean absolute error of the end effector's acceleration against the IMU."
    return Table(caption, header, body)


def _printed_table(recording: str, rows: pd.DataFrame) -> Table:
    """Table 5.7: printed, rebuilt, their difference."""
    body = [
        [
            Cell(f"{row.component} [{COMPONENTS[row.component]}]"),
            number(row.printed, 4),
            number(row.mae, 4),
            signed(100 * (row.mae / row.printed - 1), 1, " %"),
        ]
        for row in rows.itertuples()
    ]
    caption = f"Acceleration error on {recording} as published, beside Table 5.7."
    return Table(caption, ["component", "printed", "rebuilt", "diff."], body)


def _calibration_table(calibration: pd.DataFrame) -> Table:
    body = [
        [
            Cell(row.robot),
            Cell(row.quantity.replace("_", " ")),
            Cell(row.axis),
            Cell(f"{row.value:.5f} ± {row.std_error:.5f}".replace("-", "−")),
            Cell(row.unit),
        ]
        for row in calibration.itertuples()
    ]
    caption = (
        "The IMU's mounting in frame 6, the base's tilt (x and y of “up”), and the gyroscope's "
        "bias, from all recordings for fitting (± standard error)."
    )
    return Table(caption, ["arm", "quantity", "axis", "value", "unit"], body)


def _innovation_paragraph(innovations: pd.DataFrame) -> Paragraph:
    """How many channels pass the tests: the smoother's bands hold no better than its noise."""
    parts = []
    for estimate, rows in innovations.groupby("estimate", sort=False):
        consistent, white = (int((rows[test] == "yes").sum()) for test in ("consistent", "white"))
        parts.append(
            f"{estimate}: {consistent} of {len(rows)} channels have innovations of the stated "
            f"variance, {white} have white ones"
        )
    verdict = (
        "Innovations that are not white mean that encoders err in ways that repeat; then the "
        "stated standard deviations are too small."
        if (innovations["white"] == "no").any()
        else "The noise found explains the innovations."
    )
    tested = "; ".join(parts)
    return Paragraph(f"Normalised innovations were tested (95 %). {tested}. {verdict}")


def _pictures(recording: str, folder: Path) -> list[Block]:
    return [
        Picture(
            f"{content} on {recording} (after Figure {figure}).",
            folder / f"{name}.svg",
            f"Six panels over time, linear left and angular right: {content}.",
        )
        for name, (content, figure) in PICTURES.items()
    ]
