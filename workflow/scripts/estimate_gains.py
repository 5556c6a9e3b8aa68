"""The joints in closed loop, with published gains and with those that fit the recording best."""

from typing import Any

from ur5lib.identification.closed_loop import estimate_gains as fit_gains
from ur5lib.pipeline.closed_loop import (
    best,
    gain_summary,
    published_gains,
    simulated,
    tracking_of,
)
from ur5lib.records.closed_loop import ClosedLoop
from ur5lib.records.gains import GainSummary
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import write_json


def estimate_gains(input: Any, output: Any, params: Any) -> None:
    signals = Signals.read(input.signals)
    robot = load_robot(input.arm).mounted(params.gravity)
    closed_loop = ClosedLoop(time=signals.time, segment=signals.segment)
    summary = GainSummary()
    tracking = tracking_of(signals)
    if tracking is not None:
        joints, published = fit_gains(tracking), published_gains(robot)
        summary = gain_summary(tracking, joints, published)
        sets = published | {"estimated": best(joints)}
        closed_loop = simulated(signals, robot, tracking, sets)
    closed_loop.write(output.closed_loop)
    write_json(summary, output.gains)
