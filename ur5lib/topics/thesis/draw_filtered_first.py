"""Accelerations in the order of steps that the thesis's errors need, after Figures 5.14, 5.15."""

from pathlib import Path

import pandas as pd

from ur5lib.records.dynamics import Kinematics
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.topics.thesis.explained_errors import explained_accelerations
from ur5lib.topics.thesis.figure import euler_figure
from ur5lib.topics.thesis.reference import read_reference


def draw_filtered_first(
    recording: str,
    signals: Signals,
    kinematics: Kinematics,
    imu: pd.DataFrame,
    quality: Quality,
    arm: Robot,
    reference: Path,
    gravity: list[float] | None = None,
) -> dict[str, Drawing]:
    """Return the figure of accelerations by the way that explains the printed errors."""
    way = read_reference(reference).explained_accelerations()[recording]
    known = arm.mounted(gravity), signals, kinematics, imu, quality.starts["imu"]
    modelled, felt = explained_accelerations(*known, way)
    return {"accelerations_filtered_first": euler_figure(signals, felt, modelled)}
