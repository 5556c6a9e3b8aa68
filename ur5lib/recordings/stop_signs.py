"""Stop signs: what in a recording contradicts the study so much that no forces may be stated."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import islice
from typing import Any

import pandas as pd

from ur5lib.recordings.arm_checks import foreign_torque, tool_off_flange
from ur5lib.recordings.block_means import block_means
from ur5lib.recordings.current_checks import foreign_currents, undeclared_load
from ur5lib.recordings.exchanged import check_exchanged
from ur5lib.recordings.intake import Intake
from ur5lib.recordings.quality import Finding
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.told import told_payload
from ur5lib.tables import channel

FEWEST = 30  # blocks of a recording that can contradict an arm


def with_stop_signs(intake: Intake, arm: Robot, payload: Payload | None, role: str) -> Intake:
    """Return the intake with the stop signs among its findings.

    arm: under the recording's gravity; payload, role: as the study declares them.
    """
    signs = check_exchanged(intake.robot)
    contradictions = _contradictions(intake, arm, payload, fitted=role == "fit")
    for detail in islice(contradictions, 1):  # others follow from the first
        signs.append(Finding("robot", "contradiction", "stop", 1, detail))
    findings = [*intake.quality["findings"], *(sign.as_row() for sign in signs)]
    return replace(intake, quality=intake.quality | {"findings": findings})


def stop_signs(quality: Mapping[str, Any]) -> list[str]:
    """Return the details of the stop signs in a quality.json."""
    return [row["detail"] for row in quality["findings"] if row["severity"] == "stop"]


def _contradictions(
    intake: Intake, arm: Robot, payload: Payload | None, fitted: bool
) -> Iterator[str]:
    """Yield what contradicts the arm and what it carries, the most telling first."""
    robot, told = intake.robot, _told(intake.robot)
    means, declared = block_means(robot, intake.quality["period_s"]), payload or told
    if len(means.q) < FEWEST:
        return
    yield from foreign_torque(means, arm, [told, declared])
    yield from tool_off_flange(robot, arm)
    yield from foreign_currents(means, arm.carrying(declared))
    if fitted:  # elsewhere, the fit finds an undeclared load
        yield from undeclared_load(means, arm.carrying(told), arm.carrying(declared))


def _told(robot: pd.DataFrame) -> Payload | None:
    """Return the payload that the controller was given."""
    mass = robot["payload"].to_numpy() if "payload" in robot else None
    center, inertia = (
        channel(robot, name, count) if f"{name}_0" in robot else None
        for name, count in (("payload_cog", 3), ("payload_inertia", 6))
    )
    return told_payload(mass, center, inertia)
