"""Accelerations filtered before rotation, as the thesis's errors imply: Figures 5.14, 5.15."""

from pathlib import Path

import pandas as pd

from ur5lib.records.dynamics import Kinematics
from ur5lib.records.opened import Opened
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.topics.thesis.explained_errors import explained_accelerations
from ur5lib.topics.thesis.figure import euler_figure
from ur5lib.topics.thesis.reference import read_reference


class Inputs(Opened):
    """What is read of a recording."""

    name: str
    gravity: list[float] | None
    quality: Quality
    imu: pd.DataFrame
    kinematics: Kinematics
    signals: Signals


@step("recording", "accelerations_filtered_first.svg", arm="described")
def draw_filtered_first(recording: Inputs, arm: Robot, reference: Path) -> dict[str, Drawing]:
    """Return by name the figure of accelerations that are computed so that they reproduce the
    printed errors.
    """
    way = read_reference(reference).explained_accelerations()[recording.name]
    modelled, felt = explained_accelerations(recording, arm.mounted(recording.gravity), way)
    return {"accelerations_filtered_first": euler_figure(recording.signals, felt, modelled)}
